/// A stand-in for VESC's vesc_c_if.h: its table has the functions that the package calls, in the slots of firmware 6.05.

#ifndef EXAMPLES_STAND_IN_VESC_C_IF_H
#define EXAMPLES_STAND_IN_VESC_C_IF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *lib_thread;

typedef enum
{
    VESC_PIN_ADC1 = 7,
    VESC_PIN_ADC2 = 8
} VESC_PIN;

typedef enum
{
    FAULT_CODE_NONE = 0
} mc_fault_code;

typedef struct
{
    void *slots_0[42];
    void (*sleep_us)(uint32_t us);
    void *slots_43[3];
    void *(*malloc)(size_t bytes);
    void (*free)(void *pointer);
    lib_thread (*spawn)(void (*function)(void *), size_t stack, char *name, void *argument);
    void (*request_terminate)(lib_thread);
    bool (*should_terminate)(void);
    void *slots_51[7];
    float (*io_read_analog)(VESC_PIN pin);
    void *slots_59[33];
    mc_fault_code (*mc_get_fault)(void);
    void *slots_93[5];
    void (*mc_set_current)(float ampere);
    void *slots_99[35];
    void (*mc_set_current_off_delay)(float seconds);
    void *slots_135[40];
    void (*timeout_reset)(void);
    void *slots_176[18];
    uint32_t (*timer_time_now)(void);
    float (*timer_seconds_elapsed_since)(uint32_t time);
    void (*timer_sleep)(float seconds);
} vesc_c_if;

typedef struct
{
    void (*stop_fun)(void *arg);
    void    *arg;
    uint32_t base_addr;
} lib_info;

#define VESC_IF ((vesc_c_if *)0x1000f800)

#define HEADER     static volatile int __attribute__((section(".program_ptr"))) prog_ptr;
#define INIT_FUN   bool __attribute__((section(".init_fun"))) init
#define INIT_START (void)prog_ptr;

bool init(lib_info *info);

#endif
