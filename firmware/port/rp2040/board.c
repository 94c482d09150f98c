#include "board.h"

#include "convert.h"
#include "device.h"
#include "port/trip.h"
#include "registers.h"
#include "wiring.h"

// --- resets --------------------------------------------------------------------------------------------------------

#define RECORD_MAGIC 0x54455352u // "RSET", in the watchdog's scratch registers, which a reset keeps

drive_fault_t board_reset_fault(uint32_t *exception, uint32_t *address)
{
    const uint32_t reason = WATCHDOG->REASON;
    const bool     marked = reason != 0u && WATCHDOG->SCRATCH[0] == RECORD_MAGIC;
    WATCHDOG->SCRATCH[0]  = 0;
    *exception            = marked ? WATCHDOG->SCRATCH[1] : 0u;
    *address              = marked ? WATCHDOG->SCRATCH[2] : 0u;
    if (reason == 0u)
    {
        return DRIVE_FAULT_NONE; // power-on, or the reset pin
    }
    if (*exception != 0u)
    {
        return DRIVE_FAULT_EXCEPTION;
    }
    return (reason & WATCHDOG_REASON_TIMER) != 0u && !marked ? DRIVE_FAULT_WATCHDOG : DRIVE_FAULT_RESTART;
}

void board_reset(uint32_t exception, uint32_t address)
{
    board_off();
    PSM_WDSEL            = PSM_WDSEL_ALL;
    WATCHDOG->SCRATCH[0] = RECORD_MAGIC;
    WATCHDOG->SCRATCH[1] = exception;
    WATCHDOG->SCRATCH[2] = address;
    WATCHDOG->CTRL       = WATCHDOG_CTRL_TRIGGER;
    for (;;)
    {
    }
}

// --- clocks --------------------------------------------------------------------------------------------------------

#define WAIT_TURNS 100000u // turns of a loop of about 10 cycles; each caller handles the time-out

static bool wait_for(const reg_t *reg, uint32_t mask, uint32_t value)
{
    for (uint32_t turn = 0; turn < WAIT_TURNS; turn++)
    {
        if ((*reg & mask) == value)
        {
            return true;
        }
    }
    return false;
}

static bool take_out_of_reset(uint32_t blocks)
{
    registers_clear(&RESETS_RESET, blocks);
    return wait_for(&RESETS_RESET_DONE, blocks, blocks);
}

/// Starts a PLL at 12 MHz * feedback / (first * second).
static bool start_pll(pll_t *pll, uint32_t feedback, uint32_t first, uint32_t second)
{
    pll->CS        = 1; // the crystal, undivided
    pll->FBDIV_INT = feedback;
    registers_clear(&pll->PWR, PLL_PWR_PD | PLL_PWR_VCOPD);
    if (!wait_for(&pll->CS, PLL_CS_LOCK, PLL_CS_LOCK))
    {
        return false;
    }
    pll->PRIM = first << PLL_PRIM_POSTDIV1_Pos | second << PLL_PRIM_POSTDIV2_Pos;
    registers_clear(&pll->PWR, PLL_PWR_POSTDIVPD);
    return true;
}

#define CRYSTAL_MHZ (WIRING_OSCILLATOR_HZ / 1000000u)
#define SYSTEM_HZ   125000000u

_Static_assert(WIRING_OSCILLATOR_HZ == 12000000u, "the PLLs' dividers");

/// Sets up 125 MHz for the system and the UART, 48 MHz for the ADC, and 1 MHz for timer and watchdog.
static bool start_clocks(void)
{
    XOSC_CTRL    = XOSC_CTRL_1_15MHZ;
    XOSC_STARTUP = 47; // 1 ms
    registers_set(&XOSC_CTRL, XOSC_CTRL_ENABLE);
    if (!wait_for(&XOSC_STATUS, XOSC_STATUS_STABLE, XOSC_STATUS_STABLE))
    {
        return false;
    }
    CLK_REF->CTRL = CLK_REF_CTRL_XOSC;
    CLK_REF->DIV  = 1u << 8;
    registers_clear(&CLK_SYS->CTRL, CLK_SYS_CTRL_AUX); // leaves the PLLs, which a boot loader may have started
    if (!wait_for(&CLK_REF->SELECTED, 1u << 2, 1u << 2) || !wait_for(&CLK_SYS->SELECTED, 1u << 0, 1u << 0))
    {
        return false;
    }
    registers_set(&RESETS_RESET, RESETS_PLL_SYS | RESETS_PLL_USB);
    if (!take_out_of_reset(RESETS_PLL_SYS | RESETS_PLL_USB) || !start_pll(PLL_SYS, 125, 6, 2) ||
        !start_pll(PLL_USB, 100, 5, 5))
    {
        return false;
    }
    CLK_SYS->DIV   = 1u << 8;
    CLK_SYS->CTRL  = CLK_SYS_CTRL_AUX;
    CLK_ADC->DIV   = 1u << 8;
    CLK_ADC->CTRL  = CLK_CTRL_ENABLE; // AUXSRC 0 is the USB's PLL
    CLK_PERI->CTRL = CLK_CTRL_ENABLE; // AUXSRC 0 is the system's clock
    WATCHDOG->TICK = WATCHDOG_TICK_ENABLE | CRYSTAL_MHZ;
    return wait_for(&CLK_SYS->SELECTED, 1u << 1, 1u << 1);
}

// --- pins and peripherals ------------------------------------------------------------------------------------------

#define ENABLE_BIT (1u << WIRING_ENABLE_PIN)
#define DRIVES_BIT (1u << WIRING_DRIVES_PIN)

static drive_config_t board_config;

/// Sets up an input with a resistor to the level that an open wire shall have.
static void start_input(uint32_t pin, bool up)
{
    PADS_BANK0[pin]    = PADS_IE | PADS_SCHMITT | (up ? PADS_PUE : PADS_PDE);
    IO_BANK0[pin].CTRL = IO_CTRL_SIO;
}

static void start_output(uint32_t pin)
{
    SIO->GPIO_OUT_CLR  = 1u << pin; // level before direction
    SIO->GPIO_OE_SET   = 1u << pin;
    PADS_BANK0[pin]    = PADS_IE | PADS_4MA;
    IO_BANK0[pin].CTRL = IO_CTRL_SIO;
}

/// Holds an output low whatever the PWM does, or connects it to the PWM.
static void connect_pwm(bool on)
{
    const uint32_t control             = IO_CTRL_PWM | (on ? 0u : IO_CTRL_OUTOVER_LOW);
    IO_BANK0[WIRING_FORWARD_PIN].CTRL  = control;
    IO_BANK0[WIRING_BACKWARD_PIN].CTRL = control;
}

static void start_pins(const drive_config_t *config)
{
    start_output(WIRING_ENABLE_PIN);
    start_output(WIRING_DRIVES_PIN);
    connect_pwm(false);
    PADS_BANK0[WIRING_FORWARD_PIN]  = PADS_4MA;
    PADS_BANK0[WIRING_BACKWARD_PIN] = PADS_4MA;
    start_input(WIRING_STOP_PIN, true);
    start_input(WIRING_FAULT_PIN, config->fault_level != 0u);
    start_input(WIRING_READY_PIN, config->ready_level == 0u);
    for (uint32_t pin = WIRING_SENSOR_PIN; pin < WIRING_SENSOR_PIN + 3u; pin++)
    {
        PADS_BANK0[pin]    = PADS_OD; // analog: neither input nor output, no resistors
        IO_BANK0[pin].CTRL = IO_CTRL_NONE;
    }
}

static void start_uart(void)
{
    // The clock is 16 * baud * divider; the divider has 6 bits behind the point.
    const uint32_t divider            = (SYSTEM_HZ * 4u + 115200u / 2u) / 115200u;
    UART0->IBRD                       = divider >> 6;
    UART0->FBRD                       = divider & 63u;
    UART0->LCR_H                      = UART_LCR_H_8 | UART_LCR_H_FEN; // FIFOs of 32 bytes, 2.8 ms
    UART0->CR                         = UART_CR_UARTEN | UART_CR_TXE | UART_CR_RXE;
    PADS_BANK0[WIRING_SEND_PIN]       = PADS_4MA;
    PADS_BANK0[WIRING_RECEIVE_PIN]    = PADS_IE | PADS_SCHMITT | PADS_PUE; // an open wire reads idle
    IO_BANK0[WIRING_SEND_PIN].CTRL    = IO_CTRL_UART;
    IO_BANK0[WIRING_RECEIVE_PIN].CTRL = IO_CTRL_UART;
}

bool board_init(const drive_config_t *config)
{
    const uint32_t blocks = RESETS_ADC | RESETS_IO_BANK0 | RESETS_PADS_BANK0 | RESETS_PWM | RESETS_TIMER | RESETS_UART0;
    board_config          = *config; // a copy, because the caller's params change later
    registers_set(&RESETS_RESET, blocks);
    if (!take_out_of_reset(RESETS_IO_BANK0 | RESETS_PADS_BANK0))
    {
        return false;
    }
    start_pins(config);
    if (!start_clocks() || !take_out_of_reset(blocks))
    {
        return false;
    }
    start_uart();
    ADC_CS = ADC_CS_EN;
    return wait_for(&ADC_CS, ADC_CS_READY, ADC_CS_READY);
}

#define TICK_PRIORITY 2u // of 0 to 3
#define STOP_PRIORITY 0u // stops interrupt a tick

#define WATCHDOG_MS   30u
#define WATCHDOG_LOAD (2u * 1000u * WATCHDOG_MS) // the watchdog counts down by two a microsecond, erratum RP2040-E1

#define STOP_EDGE IO_EDGE_HIGH(WIRING_STOP_PIN)

static uint32_t fault_edge(void)
{
    return board_config.fault_level != 0u ? IO_EDGE_HIGH(WIRING_FAULT_PIN) : IO_EDGE_LOW(WIRING_FAULT_PIN);
}

static void start_interrupt(IRQn_Type interrupt, uint32_t priority)
{
    NVIC_SetPriority(interrupt, priority);
    NVIC_EnableIRQ(interrupt);
}

void board_start(void)
{
    pwm_t *const slice = &PWM[WIRING_SLICE];
    slice->DIV         = 1u << 4;
    slice->TOP         = CONVERT_TOP - 1u; // so that a compare value of CONVERT_TOP is always high
    slice->CC          = 0;
    slice->CTR         = 0;
    slice->CSR         = PWM_CSR_EN;

    PSM_WDSEL      = PSM_WDSEL_ALL;
    WATCHDOG->LOAD = WATCHDOG_LOAD;
    WATCHDOG->CTRL = WATCHDOG_CTRL_ENABLE;

    IO_BANK0_INTR0       = STOP_EDGE | fault_edge(); // clears edges caused by the pull-ups
    IO_BANK0_PROC0_INTE0 = STOP_EDGE | fault_edge();
    start_interrupt(IO_BANK0_IRQn, STOP_PRIORITY);

    TIMER_ALARM0 = TIMER_TIMERAWL + BOARD_TICK_US;
    TIMER_INTE   = TIMER_INT_ALARM0;
    start_interrupt(TIMER_0_IRQn, TICK_PRIORITY);
}

static volatile uint32_t ticks; ///< only the tick writes it

void board_kick(void)
{
    static uint32_t kicked_at;
    const uint32_t  now = ticks;
    if (now != kicked_at)
    {
        kicked_at      = now;
        WATCHDOG->LOAD = WATCHDOG_LOAD;
    }
}

void board_off(void)
{
    SIO->GPIO_OUT_CLR = ENABLE_BIT;
    connect_pwm(false);
    PWM[WIRING_SLICE].CC = 0;
}

// --- the line ------------------------------------------------------------------------------------------------------

/// Sends a byte. With RS-485 the transceiver drives the line from the first byte on ...
static void transmit(uint8_t byte)
{
    SIO->GPIO_OUT_SET = DRIVES_BIT;
    UART0->DR         = byte;
}

/// ... and releases it once the last byte is out.
void board_release_line(void)
{
    if ((UART0->FR & UART_FR_BUSY) == 0u)
    {
        SIO->GPIO_OUT_CLR = DRIVES_BIT;
    }
}

/// The FIFO holds the bytes of a tick, which may last longer than three of them.
static int receive(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    size_t   count  = 0;
    uint32_t errors = 0;
    while (count < room && (UART0->FR & UART_FR_RXFE) == 0u)
    {
        const uint32_t data = UART0->DR;
        bytes[count++]      = (uint8_t)data;
        errors |= data & UART_DR_ERRORS;
    }
    return errors == 0u ? (int)count : MODBUS_LINE_ERROR;
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    size_t sent = 0;
    while (sent < count && (UART0->FR & UART_FR_TXFF) == 0u)
    {
        transmit(bytes[sent++]);
    }
    return sent;
}

const modbus_line_t board_line = {.receive = receive, .send = send};

// --- interrupts ----------------------------------------------------------------------------------------------------

void TIMER_0_IRQHandler(void);
void IO_BANK0_IRQHandler(void);

void TIMER_0_IRQHandler(void)
{
    TIMER_INTR = TIMER_INT_ALARM0;
    // The next alarm counts from the time of the last one, so that jitter does not add up. An alarm in the past would come
    // in an hour.
    const uint32_t next = TIMER_ALARM0 + BOARD_TICK_US;
    TIMER_ALARM0        = (int32_t)(next - TIMER_TIMERAWL) > 10 ? next : TIMER_TIMERAWL + BOARD_TICK_US;
    board_tick();
    ticks = ticks + 1u;
}

static trip_t stop_trip, fault_trip;

static void trip(trip_t *of, uint32_t edges, uint32_t edge)
{
    if ((edges & edge) != 0u)
    {
        trip_count(of);
        registers_clear(&IO_BANK0_PROC0_INTE0,
                        edge); // off until the next tick, so that a bouncing input interrupts once a tick
    }
}

void IO_BANK0_IRQHandler(void)
{
    board_off();
    const uint32_t edges = IO_BANK0_INTR0;
    trip(&stop_trip, edges, STOP_EDGE);
    trip(&fault_trip, edges, fault_edge());
    IO_BANK0_INTR0 = edges;
}

static bool is_tripped(void)
{
    return trip_has_come(&stop_trip) || trip_has_come(&fault_trip);
}

static bool take_trip(trip_t *of, uint32_t edge)
{
    const bool tripped = trip_take(of);
    registers_set(&IO_BANK0_PROC0_INTE0, edge);
    return tripped;
}

// --- the drive's port ----------------------------------------------------------------------------------------------

#define READINGS         16u
#define CONVERSION_TURNS 100u // turns of waiting for a conversion of 2 us: more than 5 us

/// Converts a channel. Returns false if the converter does not answer.
static bool convert(uint32_t channel, uint32_t *code)
{
    ADC_CS = ADC_CS_EN | channel << ADC_CS_AINSEL_Pos | ADC_CS_START;
    for (uint32_t turn = 0; turn < CONVERSION_TURNS; turn++)
    {
        const uint32_t status = ADC_CS;
        if ((status & ADC_CS_READY) != 0u)
        {
            *code = ADC_RESULT;
            return (status & ADC_CS_ERR) == 0u;
        }
    }
    return false;
}

static bool read_sensor(void *context, loop_force_t *reading)
{
    (void)context;
    uint32_t sum = 0;
    for (uint32_t i = 0; i < READINGS; i++)
    {
        uint32_t code;
        if (!convert(0, &code))
        {
            return false;
        }
        sum += code;
    }
    *reading = convert_sensor(sum, READINGS);
    return true;
}

/// Measures a quantity. One that cannot be measured exceeds every level.
static void measure(void *context, port_measured_t *measured)
{
    (void)context;
    uint32_t   current = 0;
    uint32_t   bus     = 0;
    const bool is_done = convert(1, &current) && convert(2, &bus);
    *measured          = is_done ? convert_measured(current, bus) : (port_measured_t){INT32_MAX, INT32_MAX, 0, 0};
}

/// Call this after each write to an output, because a stop may have come between the tick's checks and the write.
static void obey_trips(void)
{
    if (is_tripped())
    {
        board_off();
    }
}

static void command(void *context, loop_force_t output)
{
    (void)context;
    PWM[WIRING_SLICE].CC = convert_output(output);
    obey_trips();
}

static void enable(void *context, bool on)
{
    (void)context;
    if (on)
    {
        connect_pwm(true);
        SIO->GPIO_OUT_SET = ENABLE_BIT;
        obey_trips();
    }
    else
    {
        board_off();
    }
}

/// Returns the bit `input` if the pin is high.
static uint32_t input_of(uint32_t pins, uint32_t pin, uint32_t input)
{
    return (pins >> pin & 1u) != 0u ? input : 0u;
}

static uint32_t levels_of(uint32_t pins)
{
    return input_of(pins, WIRING_STOP_PIN, PORT_INPUT_EMERGENCY_STOP) |
           input_of(pins, WIRING_FAULT_PIN, PORT_INPUT_POWER_FAULT) |
           input_of(pins, WIRING_READY_PIN, PORT_INPUT_NOT_READY);
}

static uint32_t inputs(void *context)
{
    (void)context;
    const uint32_t edges = (take_trip(&stop_trip, STOP_EDGE) ? 1u << WIRING_STOP_PIN : 0u) |
                           (take_trip(&fault_trip, fault_edge()) ? 1u << WIRING_FAULT_PIN : 0u);
    const uint32_t pins  = SIO->GPIO_IN;
    const bool     wrong = ((pins ^ SIO->GPIO_OUT) & ENABLE_BIT) != 0u && !is_tripped(); // the read-back shows a short
    return port_inputs(&board_config, levels_of(pins | edges), levels_of(~pins | edges)) |
           (wrong ? PORT_INPUT_POWER_FAULT : 0u);
}

static uint32_t time_us(void *context)
{
    (void)context;
    return TIMER_TIMERAWL;
}

#define LOG_TURNS 4000u // twice the time of a byte

/// Drops the byte if the UART is not ready in time. Later bytes do not wait then, otherwise the watchdog would reset the chip.
static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    static bool takes = true;
    uint32_t    turns = takes ? LOG_TURNS : 1u;
    while ((UART0->FR & UART_FR_TXFF) != 0u && turns > 0u)
    {
        turns--;
    }
    takes = turns > 0u;
    if (takes)
    {
        transmit(byte);
    }
}

const port_t board_port = {.context     = 0,
                           .sensor      = CONVERT_SENSOR_RANGE,
                           .output      = CONVERT_OUTPUT_RANGE,
                           .measures    = PORT_MEASURES_CURRENT | PORT_MEASURES_BUS,
                           .measure     = measure,
                           .read_sensor = read_sensor,
                           .command     = command,
                           .enable      = enable,
                           .inputs      = inputs,
                           .time_us     = time_us,
                           .log_byte    = log_byte,
                           .pause       = board_kick};
