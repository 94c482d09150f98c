#include "board.h"

#include "port/received.h"
#include "port/trip.h"
#include "stage.h"
#include "wait.h"
#include "wiring.h"

// --- pins and peripherals ------------------------------------------------------------------------------------------

#define STOP_LINE  (1u << WIRING_STOP_PIN)
#define FAULT_LINE (1u << WIRING_FAULT_PIN)

_Static_assert(WIRING_STOP_PIN == 1 && WIRING_FAULT_PIN >= 10 && WIRING_FAULT_PIN <= 15,
               "EXTI1's and EXTI15_10's handlers");

static drive_config_t board_config;

/// Pulls a pin of port B to the level that an open wire shall have.
static void pull(uint32_t pin, bool up)
{
    GPIOB->PUPDR |= (up ? 1u : 2u) << (2 * pin);
}

static void start_pins(const drive_config_t *config)
{
    clock_on(&RCC->AHB1ENR, RCC_AHB1ENR_GPIOBEN);
    // Level before direction, so that the pin shows no other level.
    GPIOB->BSRR = 1u << (WIRING_ENABLE_PIN + 16);
    GPIOB->MODER |= 1u << (2 * WIRING_ENABLE_PIN);
    pull(WIRING_STOP_PIN, true);
    pull(WIRING_FAULT_PIN, config->fault_level != 0u);
    pull(WIRING_READY_PIN, config->ready_level == 0u);
}

/// Sets up interrupts for emergency stop and power fault becoming active. They also latch pulses between two ticks.
static void start_edges(const drive_config_t *config)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_SYSCFGEN);
    SYSCFG->EXTICR[WIRING_STOP_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (WIRING_STOP_PIN % 4));
    SYSCFG->EXTICR[WIRING_FAULT_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (WIRING_FAULT_PIN % 4));
    EXTI->RTSR |= STOP_LINE | (config->fault_level != 0u ? FAULT_LINE : 0u);
    EXTI->FTSR |= config->fault_level != 0u ? 0u : FAULT_LINE;
    EXTI->IMR |= STOP_LINE | FAULT_LINE;
}

/// Sets up the interrupt for a low supply. Below about 2.9 V neither the flash at 168 MHz nor the converters are reliable.
static void watch_supply(void)
{
    EXTI->RTSR |= PVD_LINE;
    EXTI->IMR |= PVD_LINE;
    PWR_CR |= PWR_CR_PLS_2V8; // 2.85 to 2.99 V
    PWR_CR |= PWR_CR_PVDE;
}

static void start_usart(uint32_t clock_hz)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_USART1EN);
    GPIOB->MODER |= 1u << (2 * WIRING_DRIVES_PIN);                               // low
    pull(WIRING_RECEIVE_PIN, true);                                              // an open wire reads idle
    GPIOB->AFRL |= 7u << (4 * WIRING_SEND_PIN) | 7u << (4 * WIRING_RECEIVE_PIN); // AF7
    GPIOB->MODER |= 2u << (2 * WIRING_SEND_PIN) | 2u << (2 * WIRING_RECEIVE_PIN);
    USART1->BRR = (clock_hz + 57600u) / 115200u;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
}

/// Starts a timer that counts from 0 upwards at 1 MHz.
static void start_timer(tim_t *timer, uint32_t clock_hz, uint32_t reload, uint32_t interrupts)
{
    timer->PSC  = clock_hz / 1000000u - 1u;
    timer->ARR  = reload;
    timer->EGR  = TIM_EGR_UG; // loads the prescaler ...
    timer->SR   = 0;          // ... without a tick
    timer->DIER = interrupts;
    timer->CR1  = TIM_CR1_CEN;
}

static void start_encoder(void)
{
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_TIM3EN);
    GPIOA->PUPDR |= 1u << (2 * WIRING_ENCODER_A_PIN) | 1u << (2 * WIRING_ENCODER_B_PIN);
    GPIOA->AFRL |= 2u << (4 * WIRING_ENCODER_A_PIN) | 2u << (4 * WIRING_ENCODER_B_PIN); // AF2
    GPIOA->MODER |= 2u << (2 * WIRING_ENCODER_A_PIN) | 2u << (2 * WIRING_ENCODER_B_PIN);
    TIM3->CCMR1 = TIM_CCMR1_CC1S_TI1 | TIM_CCMR1_IC1F_N8 | TIM_CCMR1_CC2S_TI2 | TIM_CCMR1_IC2F_N8;
    TIM3->SMCR  = TIM_SMCR_SMS_ENCODER;
    TIM3->ARR   = 0xffffu;
    TIM3->CR1   = TIM_CR1_CEN;
}

/// Extends the 16 bits that TIM3 counts; the arm moves by less than half of their range in a tick.
static int32_t take_position(void)
{
    static uint16_t counted;
    static uint32_t position;
    const uint16_t  count = (uint16_t)TIM3->CNT;
    const int32_t   moved = (int16_t)(uint16_t)(count - counted);
    counted               = count;
    position += (uint32_t)moved;
    return (int32_t)position;
}

static uint32_t apb_hz; ///< clock of APB2; APB1's timers have the same clock

board_clock_t board_init(const drive_config_t *config, loop_force_t no_current)
{
    board_config = *config; // a copy, because the caller's params change later
    start_pins(config);
    stage_init(config, no_current);
    start_edges(config);
    const board_clock_t clock = clock_start(config->crystal_hz);
    apb_hz                    = clock.apb_hz; // APB1's timers run at twice its clock if it is divided
    start_usart(clock.apb_hz);
    start_encoder();
    return clock;
}

// From the linker script.
extern uint32_t stack_guard[];

#define STORE_SECTORS_MASK 0xc0u // subregions of 128 KiB: the last two sectors hold the drive's params

/// Flash is read-only except the sectors of the params, the stack ends at a guard, and RAM is not executable. A violation is a
/// hard fault, whose handler runs without these limits.
static void start_mpu(void)
{
    ARM_MPU_Disable();
    ARM_MPU_SetRegionEx(0,
                        0x08000000u,
                        ARM_MPU_RASR(0, ARM_MPU_AP_RO, 0, 0, 1, 0, STORE_SECTORS_MASK, ARM_MPU_REGION_SIZE_1MB));
    ARM_MPU_SetRegionEx(1, 0x20000000u, ARM_MPU_RASR(1, ARM_MPU_AP_FULL, 0, 1, 1, 0, 0, ARM_MPU_REGION_SIZE_128KB));
    ARM_MPU_SetRegionEx(2,
                        (uint32_t)stack_guard,
                        ARM_MPU_RASR(1, ARM_MPU_AP_NONE, 0, 1, 1, 0, 0, ARM_MPU_REGION_SIZE_256B));
    ARM_MPU_Enable(MPU_CTRL_PRIVDEFENA_Msk);
    SCB->SHCSR &= ~SCB_SHCSR_MEMFAULTENA_Msk; // set by CMSIS; a separate fault would need the full stack
}

void board_start_interrupt(IRQn_Type interrupt, uint32_t priority)
{
    NVIC_SetPriority(interrupt, priority);
    NVIC_EnableIRQ(interrupt);
}

void board_start(void)
{
    start_mpu();
    board_start_interrupt(TIM2_IRQn, BOARD_TICK_PRIORITY);
    USART1->CR1 |= USART_CR1_RXNEIE;
    board_start_interrupt(USART1_IRQn, BOARD_LINE_PRIORITY);

    IWDG->KR  = IWDG_KR_START;
    IWDG->KR  = IWDG_KR_ACCESS;
    IWDG->PR  = 0;   // LSI / 4, 8 kHz (4 to 12)
    IWDG->RLR = 240; // 30 ms (20 to 60)
    // After a time-out the watchdog runs with its longest period until the new one is loaded.
    (void)wait_for(&IWDG->SR, IWDG_SR_PVU | IWDG_SR_RVU, 0);
    IWDG->KR = IWDG_KR_RELOAD;
    watch_supply();
    EXTI->PR = STOP_LINE | FAULT_LINE | PVD_LINE; // clears edges caused by the pull-ups
    board_start_interrupt(EXTI1_IRQn, BOARD_STOP_PRIORITY);
    board_start_interrupt(EXTI15_10_IRQn, BOARD_STOP_PRIORITY);
    board_start_interrupt(PVD_IRQn, BOARD_STOP_PRIORITY);

    clock_on(&RCC->APB1ENR, RCC_APB1ENR_TIM2EN | RCC_APB1ENR_TIM5EN);
    stage_start(apb_hz);
    start_timer(TIM5, apb_hz, UINT32_MAX, 0);
    start_timer(TIM2, apb_hz, BOARD_TICK_US - 1u, TIM_DIER_UIE);
}

static volatile uint32_t ticks; ///< only the tick writes it

void board_kick(void)
{
    static uint32_t kicked_at;
    const uint32_t  now = ticks;
    if (now != kicked_at)
    {
        kicked_at = now;
        IWDG->KR  = IWDG_KR_RELOAD;
    }
}

void board_off(void)
{
    GPIOB->BSRR = 1u << (WIRING_ENABLE_PIN + 16);
    stage_off();
}

bool board_is_off(void)
{
    return (GPIOB->ODR >> WIRING_ENABLE_PIN & 1u) == 0u && stage_is_off();
}

// --- the line ------------------------------------------------------------------------------------------------------

int board_read_byte(void)
{
    const uint32_t status = USART1->SR;
    if ((status & (USART_SR_RXNE | USART_SR_ORE)) == 0u)
    {
        return BOARD_NO_BYTE;
    }
    const int byte = (int)(USART1->DR & 0xffu); // clears the errors as well
    return (status & (USART_SR_ORE | USART_SR_PE | USART_SR_FE | USART_SR_NF)) == 0u ? byte : BOARD_BAD_BYTE;
}

static bool is_sending; // a byte was sent since the last call of board_release_line

/// Sends a byte. With RS-485 the transceiver drives the line from the first byte on ...
static void transmit(uint8_t byte)
{
    GPIOB->BSRR = 1u << WIRING_DRIVES_PIN;
    USART1->DR  = byte;
    is_sending  = true;
}

/// ... and releases it once the last byte is out and no byte has followed between two calls.
void board_release_line(void)
{
    const bool is_out = (USART1->SR & USART_SR_TC) != 0u;
    if (is_out && !is_sending)
    {
        GPIOB->BSRR = 1u << (WIRING_DRIVES_PIN + 16);
    }
    is_sending = !is_out;
}

static received_t received;

void USART1_IRQHandler(void);

/// Receives in an interrupt, because the USART holds only one byte, 87 us long, and the background may be busy for milliseconds.
void USART1_IRQHandler(void)
{
    const int byte = board_read_byte();
    received_put(&received, (uint8_t)byte, byte >= 0);
}

static int receive(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    return received_take(&received, bytes, room);
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    size_t sent = 0;
    while (sent < count && (USART1->SR & USART_SR_TXE) != 0u)
    {
        transmit(bytes[sent++]);
    }
    return sent;
}

const modbus_line_t board_line = {.receive = receive, .send = send};

// --- interrupts ----------------------------------------------------------------------------------------------------

void TIM2_IRQHandler(void);
void EXTI1_IRQHandler(void);
void EXTI15_10_IRQHandler(void);
void PVD_IRQHandler(void);

void TIM2_IRQHandler(void)
{
    TIM2->SR = ~TIM_SR_UIF;
    board_tick();
    ticks = ticks + 1u;
}

static trip_t stop_trip, fault_trip, supply_trip;

/// Turns the outputs off at once. The next tick raises the fault and enables the interrupt again, so a bouncing input costs
/// at most one interrupt a tick.
static void trip(trip_t *of, uint32_t line, IRQn_Type interrupt)
{
    board_off();
    trip_count(of);
    NVIC_DisableIRQ(interrupt);
    EXTI->PR = line;
    (void)EXTI->PR; // the read completes the write before the interrupt returns
}

void EXTI1_IRQHandler(void)
{
    trip(&stop_trip, STOP_LINE, EXTI1_IRQn);
}

void EXTI15_10_IRQHandler(void)
{
    trip(&fault_trip, FAULT_LINE, EXTI15_10_IRQn);
}

void PVD_IRQHandler(void)
{
    trip(&supply_trip, PVD_LINE, PVD_IRQn);
}

static bool is_tripped(void)
{
    return trip_has_come(&stop_trip) || trip_has_come(&fault_trip) || trip_has_come(&supply_trip);
}

/// Call this after each write to an output, because a stop may have come between the tick's checks and the write.
static void obey_trips(void)
{
    if (is_tripped())
    {
        board_off();
    }
}

// --- the drive's port ----------------------------------------------------------------------------------------------

static bool read_sensor(void *context, loop_force_t *reading)
{
    (void)context;
    return stage_read_sensor(reading);
}

static void command(void *context, loop_force_t output)
{
    (void)context;
    stage_command(output);
    obey_trips();
}

static void enable(void *context, bool on)
{
    (void)context;
    GPIOB->BSRR = on ? 1u << WIRING_ENABLE_PIN : 1u << (WIRING_ENABLE_PIN + 16);
    stage_enable(on);
    obey_trips();
}

static bool take_trip(trip_t *of, IRQn_Type interrupt)
{
    const bool tripped = trip_take(of);
    NVIC_EnableIRQ(interrupt);
    return tripped;
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

static bool is_high(uint32_t pins, uint32_t pin)
{
    return (pins >> pin & 1u) != 0u;
}

#define READY_OFF_TICKS 100u

/// Reads enable back, which shows a short or a stage that stays on. The ready output, if there is one, must fall once enable
/// is off.
static bool is_stage_wrong(uint32_t pins)
{
    static uint32_t off_ticks;
    const bool      is_on = is_high(GPIOB->ODR, WIRING_ENABLE_PIN);
    const bool      is_ready =
        board_config.ready_ms > 0u && is_high(pins, WIRING_READY_PIN) == (board_config.ready_level != 0u);
    off_ticks = is_on ? 0u : off_ticks + (off_ticks <= READY_OFF_TICKS);
    return is_high(pins, WIRING_ENABLE_PIN) != is_on || (is_ready && off_ticks > READY_OFF_TICKS);
}

static uint32_t inputs(void *context)
{
    (void)context;
    const uint32_t edges = (take_trip(&stop_trip, EXTI1_IRQn) ? STOP_LINE : 0u) |
                           (take_trip(&fault_trip, EXTI15_10_IRQn) ? FAULT_LINE : 0u);
    const bool     low     = take_trip(&supply_trip, PVD_IRQn) || (PWR_CSR & PWR_CSR_PVDO) != 0u;
    const uint32_t pins    = GPIOB->IDR;
    const bool     wrong   = is_stage_wrong(pins) && !is_tripped(); // a trip has just turned enable off
    const uint32_t by_pins = port_inputs(&board_config, levels_of(pins | edges), levels_of(~pins | edges));
    return (by_pins & ~STAGE_OWN_INPUTS) | stage_inputs() | (low ? PORT_INPUT_SUPPLY : 0u) |
           (wrong ? PORT_INPUT_POWER_FAULT : 0u);
}

static void measure(void *context, port_measured_t *measured)
{
    (void)context;
    stage_measure(measured);
    measured->position = take_position();
}

static uint32_t time_us(void *context)
{
    (void)context;
    return TIM5->CNT;
}

#define LOG_TURNS 4000u // 0.2 ms at 168 MHz, twice the time of a byte

/// Drops the byte if the USART is not ready in time. Later bytes do not wait then, otherwise the watchdog would reset the chip.
static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    static bool takes = true;
    takes             = wait_for_turns(&USART1->SR, USART_SR_TXE, USART_SR_TXE, takes ? LOG_TURNS : 1u);
    if (takes)
    {
        transmit(byte);
    }
}

const port_t board_port = {.context  = 0,
                           .sensor   = CONVERT_SENSOR_RANGE,
                           .output   = STAGE_OUTPUT_RANGE,
                           .measures = PORT_MEASURES_CURRENT | PORT_MEASURES_BUS | PORT_MEASURES_TEMPERATURE |
                                       PORT_MEASURES_POSITION,
                           .measure     = measure,
                           .read_sensor = read_sensor,
                           .command     = command,
                           .enable      = enable,
                           .inputs      = inputs,
                           .time_us     = time_us,
                           .log_byte    = log_byte,
                           .pause       = board_kick};
