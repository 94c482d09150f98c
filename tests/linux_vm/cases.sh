# The tests with one build of tribo-drive, $drive; sourced by init.sh.

# start RIG [OPTION...]: the drive in lock-step, its process in $pid; tick: one tick.
start() {
    rm -f in out
    mkfifo in out
    $drive "$@" --ticks in,out >out.txt 2>err.txt &
    pid=$!
    exec 3>in 4<out
}
tick() { printf . >&3 && head -c 1 <&4 >/dev/null; }
finish() { # closes the ends, waits, leaves the exit status in $status
    exec 3>&- 4<&-
    wait $pid
    status=$?
}
loop_of() { tr -d " " </proc/$1/task/$1/children; }

# --- opening -------------------------------------------------------------------------------------------------------

$drive rig.yaml --check >out.txt 2>err.txt
check $version.check "$(cat err.txt)" grep -q "nothing has moved" out.txt
check $version.check_leaves_all_off "enable $(level 0), duty $(cat $duty)" stopped

start rig.yaml
tick
$drive rig.yaml --check >out2.txt 2>err2.txt
check $version.busy_line "$(cat err2.txt)" grep -q "lines.enable ('enable'): cannot be requested: Device or resource busy" err2.txt
check $version.consumer "$(gpioinfo)" sh -c 'gpioinfo | grep -q tribo-drive'
finish

refused() { # NAME MESSAGE SED: a rig.yaml changed by SED is refused with MESSAGE
    sed "$3" rig.yaml >bad.yaml
    $drive bad.yaml --check >out.txt 2>err.txt
    check $version.$1 "$(cat err.txt)" grep -q "$2" err.txt
}
refused unknown_line "lines.enable ('nothing'): there is no such line" 's/{name: enable}/{name: nothing}/'
refused unknown_chip "lines.probe (nowhere line 1): there is no such line" 's/chip: drive/chip: nowhere/'
refused no_such_offset "lines.probe (drive line 77)" 's/offset: 1/offset: 77/'
refused unknown_device "sensor.device: there is no IIO device 'ads9'" 's/device: ads1015/device: ads9/'
refused unknown_channel "sensor.channel: 'ads1015' has no input channel 'voltage9'" 's/voltage0/voltage9/'
refused unknown_pwm "pwm.chip: there is no /sys/class/pwm/pwmchip7" 's/pwmchip0/pwmchip7/'
refused pwm_channel "pwm.channel: /sys/class/pwm/pwmchip0 does not give channel 9" 's/channel: 0/channel: 9/'

# --- a tick --------------------------------------------------------------------------------------------------------

set_code() { i2cset -y -f ${i2c##*-} 0x48 0 $1 w; } # low byte first: 0x3412 is 0x1234
set_code 0x0020 # 0x2000, 8192 codes of 0.0625 mV: 0.5 N
start rig.yaml --log log.csv
tick
tick
check $version.runs_after_start "$(cat err.txt)" [ "$(level 0)" = 1 ]
probe_low=$(level 1)
tick
set=$(cat $duty)
finish
check $version.probe_is_low_between_ticks "$probe_low" [ "$probe_low" = 0 ]
check $version.code_through_scale "$(cat log.csv)" sh -c 'tail -n 1 log.csv | cut -d, -f3 | grep -q "^0.5$"'
wanted=$(tail -n 1 log.csv | awk -F, '{printf "%.0f", (0.5 + $4 / 4) * 50000}')
check $version.duty_is_the_command "$set, not $wanted" [ "$set" = "$wanted" ]
check $version.ends_with_its_ticks "$status" [ $status = 0 ]
check $version.ends_off "enable $(level 0), duty $(cat $duty)" stopped

# A driver with an offset, 13657.5 codes of 20 mK: (14745 - 13657.5) 20 mK 2e-5 N/mK.
i2cset -y -f ${i2c##*-} 0x5a 7 0x3999 w
sed 's/device: ads1015, channel: voltage0/device: mlx90614, channel: temp_object/; s/sensor_n_per_unit: 0.0009765625/sensor_n_per_unit: 2e-5/' \
    rig.yaml >offset.yaml
start offset.yaml --log log.csv
tick
tick
finish
check $version.code_through_offset "$(cat log.csv err.txt)" sh -c 'tail -n 1 log.csv | cut -d, -f3 | grep -q "^0.435"'

# Inverted lines: enable is high when it is off, by its pull-up also once the process has left it, and a low emergency stop stops.
sed 's/{name: enable}/{name: enable, active_low: yes}/; s/{name: emergency_stop}/{name: emergency_stop, active_low: yes}/' rig.yaml >low.yaml
pull 0 up
pull 3 up
start low.yaml
tick
on=$(level 0)
pull 3 down
tick
stop=$(level 0)
finish
pull 0 down
check $version.active_low "$on$stop, status $status: $(cat err.txt)" sh -c "[ $on$stop = 01 ] && [ $status = 3 ] && grep -q 'emergency stop' err.txt"

# --- ready ---------------------------------------------------------------------------------------------------------

sed 's/^lines:/lines:\n  ready: {name: ready}/; s/^drive:/drive:\n  ready_ms: 5/' rig.yaml >ready.yaml
# An edge since the last tick counts as both levels, so a stage that becomes ready is ready in the next tick.
ready() { # LEVEL_FROM_TICK_3 LEVEL_FROM_TICK_6: six ticks, their states in $states
    pull 4 down
    start ready.yaml --log log.csv
    tick
    tick
    pull 4 $1
    tick
    tick
    tick
    pull 4 $2
    tick
    last=$(level 0)
    finish
    states=$(tail -n +2 log.csv | cut -d, -f5 | tr -d "\n")
    said="states $states, enable $last, status $status: $(cat err.txt)"
}
ready up up
check $version.ready_in_time "$said" sh -c "[ $states = 333111 ] && [ $last = 1 ] && [ $status = 0 ]"
ready up down
check $version.ready_lost "$said" sh -c "[ $states = 333112 ] && [ $last = 0 ] && [ $status = 3 ] && grep -q 'power stage not ready' err.txt"
ready down down
check $version.ready_never "$said" sh -c "[ $states = 333332 ] && [ $last = 0 ] && [ $status = 3 ] && grep -q 'power stage not ready' err.txt"

pull 4 up
$drive ready.yaml --check >out.txt 2>err.txt
check $version.ready_though_off "$(cat err.txt)" grep -q "lines.ready ('ready'): the power stage is ready, though enable has been off for 100 ms" err.txt
pull 4 down

# --- stops ---------------------------------------------------------------------------------------------------------

stop_by() { # NAME LINE CAUSE
    start rig.yaml
    tick
    tick
    before=$(level 0)
    pull $2 up
    tick
    after="$before$(level 0) $(cat $duty)"
    finish
    pull $2 down
    check $version.$1 "$after, status $status: $(cat err.txt)" sh -c "[ '$after' = '10 25000' ] && [ $status = 3 ] && grep -q '$3' err.txt"
}
stop_by emergency_stop_in_the_tick 3 "emergency stop"
stop_by power_fault_in_the_tick 2 "power stage"

# An edge of the heartbeat with each tick, none from the fault on.
start rig.yaml
pulses=
for i in 1 2 3 4; do
    tick
    pulses=$pulses$(level 5)
done
pull 3 up
tick
pulses=$pulses$(level 5)
finish
pull 3 down
check $version.heartbeat "$pulses" [ $pulses = 10100 ]

start rig.yaml
tick
tick
pull 3 up
pull 3 down
tick
after="$(level 0) $(cat $duty)"
finish
check $version.pulse_between_ticks "$after: $(cat err.txt)" sh -c "[ '$after' = '0 25000' ] && grep -q 'emergency stop' err.txt"

# Its own pull-up is all that an open wire has.
sed 's/{name: emergency_stop}/{name: emergency_stop, bias: pull_up}/' rig.yaml >open.yaml
start open.yaml
tick
finish
pull 3 down
check $version.open_wire "$status: $(cat err.txt)" sh -c "[ $status = 3 ] && grep -q 'emergency stop' err.txt"

start rig.yaml
tick
tick
before=$(level 0)
echo 0x48 >$bus/delete_device
tick
after="$before$(level 0) $(cat $duty)"
finish
echo ads1115 0x48 >$bus/new_device
check $version.sensor_removed "$after, status $status: $(cat err.txt)" sh -c "[ '$after' = '10 25000' ] && grep -q 'sensor silent' err.txt"

# --- processes -----------------------------------------------------------------------------------------------------

set_code 0x9019 # 0x1990
for signal in KILL STOP TERM INT; do
    $drive clock.yaml >out.txt 2>err.txt &
    pid=$!
    if ! until_level 0 1; then
        not_ok $version.$signal "does not start: $(cat err.txt)"
        continue
    fi
    target=$(loop_of $pid)
    case $signal in TERM | INT) target=$pid ;; esac
    took=$(linux_vm_signal $target $signal $lines/sim_gpio0/value)
    wait $pid
    status=$?
    echo "value $version.$signal.ms $took"
    check $version.$signal "enable is low after $took ms, duty $(cat $duty), status $status: $(cat err.txt)" stopped
done

# The output's driver blocks for 1 s from then on; NONE: and nobody does anything.
block=/sys/module/mock_pwm/parameters/block_ms
for signal in KILL STOP NONE; do
    $drive clock.yaml >out.txt 2>err.txt &
    pid=$!
    until_level 0 1
    took=$(linux_vm_signal $(loop_of $pid) $signal $lines/sim_gpio0/value $block 1000)
    wait $pid
    status=$?
    echo 0 >$block
    echo "value $version.BLOCKED_$signal.ms $took"
    check $version.BLOCKED_$signal "enable is low after $took ms, duty $(cat $duty), status $status: $(cat err.txt)" stopped
done

# All processes of the drive's name are killed.
$drive clock.yaml >out.txt 2>err.txt &
pid=$!
until_level 0 1
for process in /proc/[0-9]*; do
    [ "$(cat $process/comm)" = $drive ] && kill -KILL ${process#/proc/}
done
wait $pid
status=$?
check $version.killed_by_name "enable $(level 0), status $status: $(cat err.txt)" sh -c "[ $status = 137 ] && grep -q ', stopped$' err.txt && [ $(level 0) = 0 ]" # the supervisor has lived to say so

# The supervisor is killed: the loop ends by itself.
$drive clock.yaml >out.txt 2>err.txt &
pid=$!
until_level 0 1
loop=$(loop_of $pid)
took=$(linux_vm_signal $pid KILL $lines/sim_gpio0/value)
wait $pid
until_gone $loop
check $version.supervisor_killed "enable $(level 0), duty $(cat $duty) after $took ms" stopped

# One priority more than the loop's.
$drive clock.yaml >out.txt 2>err.txt &
pid=$!
until_level 0 1
priorities=$(cut -d" " -f40 /proc/$pid/stat /proc/$(loop_of $pid)/stat | tr "\n" " ")
kill -TERM $pid
wait $pid
check $version.priorities "$priorities" [ "$priorities" = "81 80 " ]

# --- the watchdog of the machine ------------------------------------------------------------------------------------

# Of 30 s, which the drive makes 1 s: kept alive for 2 s, disarmed at the end.
sed 's/watchdog: none/watchdog: \/dev\/watchdog/' clock.yaml >dog.yaml
mark $version.watchdog_kept
$drive dog.yaml --duration 2 >out.txt 2>err.txt
status=$?
sleep 2
check $version.watchdog_opens "status $status: $(cat err.txt)" [ $status = 0 ]

# Nobody is left to turn anything off.
mark $version.watchdog_killed
$drive dog.yaml >out.txt 2>err.txt &
pid=$!
until_level 0 1
loop=$(loop_of $pid)
kill -STOP $pid
kill -KILL $loop $pid
wait $pid
sleep 2
mark $version.watchdog_over
# The kernel counts it as running, and QEMU has reset it.
printf V >/dev/watchdog
rmmod i6300esb
insmod /lib/modules/i6300esb.ko heartbeat=30
sed 's/watchdog: .*/watchdog: \/dev\/watchdog7/' dog.yaml >bad.yaml
$drive bad.yaml >out.txt 2>err.txt
check $version.no_watchdog "$(cat err.txt)" sh -c "[ $(level 0) = 0 ] && grep -q 'watchdog: /dev/watchdog7: No such file' err.txt"

# --- a DAC in place of the PWM ---------------------------------------------------------------------------------------

# 0x80 is the sign of its code.
set_code 0x0020
sink() { printf '%d' $(i2cget -y -f ${i2c##*-} 0x10 0xf8); }
start dac.yaml --log log.csv
tick
tick
tick
set=$(sink)
finish
wanted=$(tail -n 1 log.csv | awk -F, '{u = sprintf("%.0f", $4 / 0.05); print u < 0 ? -u : u + 128}')
check $version.dac_is_the_command "$set, not $wanted: $(cat err.txt)" [ "$set" = "$wanted" ]
check $version.dac_ends_off "enable $(level 0), code $(sink)" sh -c "[ $(level 0) = 0 ] && [ $(($(sink) % 128)) = 0 ]"

# --- the loop ------------------------------------------------------------------------------------------------------

track() { # RIG SCENARIO
    set_code 0
    rm -f in out
    mkfifo in out
    $drive $1 --ticks in,out >out.txt 2>err.txt &
    pid=$!
    linux_vm_plant $2 $duty $i2c $ticks in out 2>plant.txt || kill $pid
    wait $pid
}
begin=$(cut -d' ' -f1 /proc/uptime)
on=$(track rig.yaml triangle.yaml)
err=$(cat plant.txt err.txt)
off=$(track rig_off.yaml off.yaml)
echo "value $version.triangle.with ${on#rms }"
echo "value $version.triangle.without ${off#rms }"
echo "value $version.triangle.tick_us $(awk -v a=$begin -v n=$ticks '{printf "%.0f", ($1 - a) * 5e5 / n}' /proc/uptime)"
check $version.triangle "$err $(cat plant.txt err.txt)" [ -n "$on" -a -n "$off" ]

# --- a failing output -----------------------------------------------------------------------------------------------

start rig.yaml
tick
tick
before=$(level 0)
echo mock_pwm >/sys/bus/platform/drivers/mock_pwm/unbind
tick
after="$before$(level 0)"
finish
echo mock_pwm >/sys/bus/platform/drivers/mock_pwm/bind
check $version.output_removed "$after, status $status: $(cat err.txt)" sh -c "[ '$after' = '10' ] && [ $status = 1 ] && grep -q 'a device or line fails' err.txt"

# --- lines that vanish ----------------------------------------------------------------------------------------------

start rig.yaml
tick
tick
before=$(level 0)
echo 0 >$chip/live
tick
after="$before$(cat $duty)"
finish
echo 1 >$chip/live
find_lines
pull 2 down
pull 3 down
check $version.chip_removed "$after, status $status: $(cat err.txt)" sh -c "[ '$after' = '125000' ] && [ $status = 1 ] && grep -q 'a device or line fails' err.txt"
start rig.yaml
tick
tick
back=$(level 0)
finish
check $version.chip_is_back "$back, status $status: $(cat err.txt)" [ $back$status = 10 ]
