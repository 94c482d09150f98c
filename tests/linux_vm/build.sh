#!/usr/bin/env bash
# Makes the test machine: build.sh OUT_DIR TICKS PLANT SIGNAL VERSION=TRIBO_DRIVE...       TICKS: of the closed loop
#
# Debian's own kernel, its drivers of an ADC, of a DAC, of a sensor with an offset, of a simulated I2C bus and of the watchdog that QEMU has, and two modules that it lacks, built against
# its headers: gpio-sim out of linux-source, and mock_pwm.c. tools/setup vm brings them.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1 ticks=$2 plant=$3 signal=$4
shift 4
kernel=$(dpkg-query -W -f '${Depends}' linux-headers-amd64 | sed -E 's/^linux-headers-([^ ]+).*/\1/')
cache="${XDG_CACHE_HOME:-$HOME/.cache}/tribo/linux/$kernel"
headers=/usr/src/linux-headers-$kernel
rm -rf "$out/root"
mkdir -p "$out/modules" "$out/root"/{bin,dev,lib/modules,proc,sys,tests,tmp}

# The modules, once for a kernel and its mock_pwm.c.
if [ ! -e "$out/modules/$kernel" ] || [ "$here/mock_pwm.c" -nt "$out/modules/$kernel" ]; then
    cp "$here"/{Kbuild,mock_pwm.c} "$out/modules"
    cp "$cache"/source/* "$out/modules"
    # irq_to_desc is not exported to modules, this way to it is.
    sed -i 's/irq_to_desc(irqnum)/irq_data_to_desc(irq_get_irq_data(irqnum))/' "$out/modules/irq_sim.c"
    make -s -C "$headers" M="$(realpath "$out/modules")" modules >"$out/modules.log" 2>&1 || {
        cat "$out/modules.log" >&2
        exit 1
    }
    touch "$out/modules/$kernel"
fi

root=$out/root
cp "$cache"/modules/* "$root/lib/modules"
cp "$out"/modules/{gpio_sim,mock_pwm}.ko "$root/lib/modules"
for file in "$root"/lib/modules/*.xz; do [ ! -e "$file" ] || xz -d "$file"; done
printf '%s\n' configfs.ko industrialio.ko kfifo_buf.ko industrialio-triggered-buffer.ko ti-ads1015.ko ds4424.ko mlx90614.ko i2c-dev.ko \
    gpio_sim.ko mock_pwm.ko "i2c-stub.ko chip_addr=0x48,0x10,0x5a" watchdog.ko "i6300esb.ko heartbeat=30" >"$root/lib/modules/order.txt"

# put NAME FILE: a program with its libraries.
put() {
    install -m 755 "$2" "$root/bin/$1"
    ldd "$2" | awk '/=> \//{print $3} /^\t\/lib/{print $1}' | while read -r library; do
        mkdir -p "$root$(dirname "$library")"
        cp -nL "$library" "$root$library"
    done
}
cp /bin/busybox "$root/bin/busybox"
put linux_vm_plant "$plant"
put linux_vm_signal "$signal"
put i2cset "$(command -v i2cset || echo /usr/sbin/i2cset)"
put gpioinfo "$(command -v gpioinfo)"
for drive in "$@"; do
    put "tribo-drive-${drive%%=*}" "${drive#*=}"
done
cp "$here"/*.yaml "$here/cases.sh" "$root/tests"
install -m 755 "$here/init.sh" "$root/init"
echo "$ticks" >"$root/tests/ticks"
(cd "$root" && find . | LC_ALL=C sort | cpio -o -H newc --quiet) | gzip -1 >"$out/initrd.gz"
cp "$cache/vmlinuz" "$out/kernel"
