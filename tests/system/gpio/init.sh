#!/bin/busybox sh
# The guest's first process: loads the modules, mounts the host's files (writes stay in memory), runs the command.
export PATH=/bin
/bin/busybox --install -s /bin
trap 'poweroff -f' EXIT
mount -t devtmpfs dev /dev
for module in /modules/*; do
    case "$module" in
    *i2c-stub*) insmod "$module" chip_addr=0x60 ;; # a chip of 256 registers
    *) insmod "$module" ;;
    esac
done
ln -s i2c-0 /dev/i2c-1 # the header's bus
mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=262144 host /host
mount -t tmpfs written /written
mkdir /written/upper /written/work
mount -t overlay -o lowerdir=/host,upperdir=/written/upper,workdir=/written/work root /root
mount --move /dev /root/dev
mount -t proc proc /root/proc
mount -t sysfs sys /root/sys
mount -t configfs config /root/sys/kernel/config
mount -t tmpfs run /root/run

# gpiozero reads the board from its revision: this one is a Raspberry Pi 3B.
{ cat /root/proc/cpuinfo; echo "Revision : a02082"; } > /written/cpuinfo
mount --bind /written/cpuinfo /root/proc/cpuinfo

chroot /root "$@"
