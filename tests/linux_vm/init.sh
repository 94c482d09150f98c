#!/bin/busybox sh
# The first and only program of the test machine: sets the simulated board up, runs the tests, prints a line each, ends.
#
#     ok NAME             not ok NAME: why            value NAME NUMBER            mark NAME
/bin/busybox --install -s /bin
export PATH=/bin
echo # behind what the firmware left on the line
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
cd /lib/modules
while read -r module; do insmod $module || echo "not ok setup: insmod $module"; done <order.txt
mount -t configfs none /sys/kernel/config
chip=/sys/kernel/config/gpio-sim/board
mkdir -p $chip/bank0
echo 8 >$chip/bank0/num_lines
echo drive >$chip/bank0/label
for line in 0:enable 1:probe 2:power_fault 3:emergency_stop 4:ready 5:heartbeat; do
    mkdir $chip/bank0/line${line%:*}
    echo ${line#*:} >$chip/bank0/line${line%:*}/name
done
echo 1 >$chip/live
find_lines() { lines=$(echo /sys/devices/platform/gpio-sim.0/gpiochip*/); } # of another number once it has been away
find_lines
for adapter in /sys/bus/i2c/devices/i2c-*; do
    grep -q stub $adapter/name && bus=$adapter
done
echo ads1115 0x48 >$bus/new_device
echo ds4424 0x10 >$bus/new_device
echo mlx90614 0x5a >$bus/new_device
i2c=/dev/${bus##*/}
duty=/sys/class/pwm/pwmchip0/pwm0/duty_cycle

mkdir -p /run /tests/work
cd /tests/work
cp /tests/*.yaml .
ticks=$(cat /tests/ticks) # of the closed loop

# pull LINE up|down: the level of an input from outside. level LINE: of any line.
pull() { echo pull-$2 >$lines/sim_gpio$1/pull; }
level() { cat $lines/sim_gpio$1/value; }
# mark NAME: what QEMU says of its watchdog from here on is about that.
mark() { echo "mark $1"; }
ok() { echo "ok $1"; }
not_ok() { echo "not ok $1: $2"; }
# check NAME WHAT CONDITION...: WHAT explains a failure
check() {
    local name="$1" what="$2"
    shift 2
    if "$@"; then ok "$name"; else not_ok "$name" "$what"; fi
}
stopped() { [ "$(level 0)" = 0 ] && [ "$(cat $duty)" = 25000 ]; }
until_gone() { # PID: waits for its end, at most 5 s
    local i=0
    while [ -e /proc/$1 ]; do
        i=$((i + 1))
        [ $i -lt 500 ] || return 1
        usleep 10000
    done
}
until_level() { # LINE LEVEL
    local i=0
    while [ "$(level $1)" != $2 ]; do
        i=$((i + 1))
        [ $i -lt 500 ] || return 1
        usleep 10000
    done
}

pull 2 down
pull 3 down

for version in $(cd /bin && ls -d tribo-drive-v* | sed s/tribo-drive-//); do
    drive=tribo-drive-$version
    # A shell of its own: one that cannot open a file ends.
    (find_lines && . /tests/cases.sh) || not_ok $version.cases "ended with status $?: $(cat err.txt)"
done

echo done
poweroff -f
