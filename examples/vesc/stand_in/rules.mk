# A stand-in for VESC's rules.mk: uses the flags that matter and writes an image to BUILD. The image must contain no relocation.
BUILD ?= build
CROSS ?= arm-none-eabi-

FLAGS = -mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -fpic -Os -ffunction-sections -fdata-sections -Wall -Wextra -Werror \
    -DIS_VESC_LIB -I stand_in $(USE_OPT)

$(BUILD)/$(TARGET).elf: $(SOURCES) hidden.h stand_in/vesc_c_if.h stand_in/link.ld $(wildcard $(TRIBO)/include/tribo/*.h $(TRIBO)/src/*/*.h)
	mkdir -p $(BUILD)
	$(CROSS)gcc $(FLAGS) --specs=picolibc.specs $(SOURCES) -nostartfiles -static -Wl,--gc-sections,--undefined=init,--emit-relocs \
	    -T stand_in/link.ld -o $@
