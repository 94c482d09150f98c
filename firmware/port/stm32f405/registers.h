/// The only registers of the STM32F405 that this port touches, named as in the reference manual (RM0090). The core's own
/// registers are CMSIS-Core's (device.h).

#ifndef STM32F405_REGISTERS_H
#define STM32F405_REGISTERS_H

#include <stdint.h>

typedef volatile uint32_t reg_t;

// --- RCC, reset and clock control ----------------------------------------------------------------------------------

typedef struct
{
    reg_t CR, PLLCFGR, CFGR, CIR;
    reg_t AHB1RSTR, AHB2RSTR, AHB3RSTR, reserved_1c, APB1RSTR, APB2RSTR, reserved_28, reserved_2c;
    reg_t AHB1ENR, AHB2ENR, AHB3ENR, reserved_3c, APB1ENR, APB2ENR, reserved_48, reserved_4c;
    reg_t AHB1LPENR, AHB2LPENR, AHB3LPENR, reserved_5c, APB1LPENR, APB2LPENR, reserved_68, reserved_6c;
    reg_t BDCR, CSR;
} rcc_t;

#define RCC ((rcc_t *)0x40023800u)

#define RCC_CIR_CSSF (1u << 7)
#define RCC_CIR_CSSC (1u << 23)

#define RCC_CR_HSION           (1u << 0)
#define RCC_CR_HSIRDY          (1u << 1)
#define RCC_CR_HSEON           (1u << 16)
#define RCC_CR_HSERDY          (1u << 17)
#define RCC_CR_HSEBYP          (1u << 18)
#define RCC_CR_CSSON           (1u << 19)
#define RCC_CR_PLLON           (1u << 24)
#define RCC_CR_PLLRDY          (1u << 25)
#define RCC_PLLCFGR_PLLN_Pos   6
#define RCC_PLLCFGR_PLLSRC_HSE (1u << 22)
#define RCC_PLLCFGR_PLLQ_Pos   24
#define RCC_CFGR_SW            (3u << 0)
#define RCC_CFGR_SW_PLL        (2u << 0)
#define RCC_CFGR_SWS           (3u << 2)
#define RCC_CFGR_SWS_PLL       (2u << 2)
#define RCC_CFGR_RTCPRE_Pos    16
#define RCC_CFGR_PPRE1_DIV4    (5u << 10)
#define RCC_CFGR_PPRE2_DIV2    (4u << 13)
#define RCC_AHB1ENR_GPIOAEN    (1u << 0)
#define RCC_AHB1ENR_GPIOBEN    (1u << 1)
#define RCC_APB1ENR_TIM2EN     (1u << 0)
#define RCC_APB1ENR_TIM3EN     (1u << 1)
#define RCC_APB1ENR_TIM5EN     (1u << 3)
#define RCC_APB1ENR_PWREN      (1u << 28)
#define RCC_APB1ENR_DACEN      (1u << 29)
#define RCC_APB2ENR_TIM1EN     (1u << 0)
#define RCC_APB2ENR_USART1EN   (1u << 4)
#define RCC_APB2ENR_ADC1EN     (1u << 8)
#define RCC_APB2ENR_ADC2EN     (1u << 9)
#define RCC_APB2ENR_SYSCFGEN   (1u << 14)
#define RCC_APB2ENR_TIM11EN    (1u << 18)
#define RCC_CSR_RMVF           (1u << 24)
#define RCC_CSR_BORRSTF        (1u << 25)
#define RCC_CSR_PINRSTF        (1u << 26)
#define RCC_CSR_PORRSTF        (1u << 27)
#define RCC_CSR_SFTRSTF        (1u << 28)
#define RCC_CSR_IWDGRSTF       (1u << 29)
#define RCC_CSR_WWDGRSTF       (1u << 30)

// --- FLASH and PWR -------------------------------------------------------------------------------------------------

#define FLASH_ACR  (*(reg_t *)0x40023c00u)
#define FLASH_KEYR (*(reg_t *)0x40023c04u)
#define FLASH_SR   (*(reg_t *)0x40023c0cu)
#define FLASH_CR   (*(reg_t *)0x40023c10u)

#define FLASH_OPTCR             (*(reg_t *)0x40023c14u)
#define FLASH_OPTCR_BOR_LEV     (3u << 2)
#define FLASH_OPTCR_BOR_LEV_2V7 (0u << 2) ///< level 3, the highest; the bits 3 mean no level

#define FLASH_KEY1         0x45670123u
#define FLASH_KEY2         0xcdef89abu
#define FLASH_SR_ERRORS    0xf2u // OPERR, WRPERR, PGAERR, PGPERR, PGSERR
#define FLASH_SR_BSY       (1u << 16)
#define FLASH_CR_PG        (1u << 0)
#define FLASH_CR_SER       (1u << 1)
#define FLASH_CR_SNB_Pos   3
#define FLASH_CR_PSIZE_X32 (2u << 8)
#define FLASH_CR_STRT      (1u << 16)
#define FLASH_CR_LOCK      (1u << 31)

#define FLASH_ACR_LATENCY     (7u << 0)
#define FLASH_ACR_LATENCY_5WS (5u << 0)
#define FLASH_ACR_PRFTEN      (1u << 8)
#define FLASH_ACR_ICEN        (1u << 9)
#define FLASH_ACR_DCEN        (1u << 10)
#define FLASH_ACR_ICRST       (1u << 11)
#define FLASH_ACR_DCRST       (1u << 12)

#define PWR_CR  (*(reg_t *)0x40007000u)
#define PWR_CSR (*(reg_t *)0x40007004u)

#define PWR_CR_PVDE    (1u << 4)
#define PWR_CR_PLS_2V8 (6u << 5)
#define PWR_CR_VOS     (1u << 14)
#define PWR_CSR_PVDO   (1u << 2)

// --- SYSCFG and EXTI: edges of pins, and the supply ----------------------------------------------------------------

typedef struct
{
    reg_t MEMRMP, PMC, EXTICR[4];
} syscfg_t;

#define SYSCFG ((syscfg_t *)0x40013800u)

#define SYSCFG_EXTICR_PB 1u

typedef struct
{
    reg_t IMR, EMR, RTSR, FTSR, SWIER, PR;
} exti_t;

#define EXTI ((exti_t *)0x40013c00u)

#define PVD_LINE (1u << 16) // rises when the supply falls below the level

// --- GPIO ----------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFRL, AFRH;
} gpio_t;

#define GPIOA ((gpio_t *)0x40020000u)
#define GPIOB ((gpio_t *)0x40020400u)

// --- timers TIM1, TIM2, TIM3, TIM5 and TIM11 ---------------------------------------------------------------------------

typedef struct
{
    reg_t CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR;
    reg_t RCR, CCR1, CCR2, CCR3, CCR4, BDTR, DCR, DMAR, OR;
} tim_t;

#define TIM1  ((tim_t *)0x40010000u)
#define TIM2  ((tim_t *)0x40000000u)
#define TIM3  ((tim_t *)0x40000400u)
#define TIM5  ((tim_t *)0x40000c00u)
#define TIM11 ((tim_t *)0x40014800u)

#define TIM_CCMR1_CC1S_TI1    (1u << 0)
#define TIM_CCMR1_IC1F_N8     (3u << 4) // eight equal samples
#define TIM_CCMR1_CC2S_TI2    (1u << 8)
#define TIM_CCMR1_IC2F_N8     (3u << 12)
#define TIM_CCMR1_IC1PSC_DIV8 (3u << 2)
#define TIM_SMCR_SMS_ENCODER  (3u << 0) // both edges of both inputs
#define TIM_CCER_CC1E         (1u << 0)
#define TIM_SR_CC1IF          (1u << 1)
#define TIM_SR_CC1OF          (1u << 9)
#define TIM11_OR_TI1_HSE_RTC  (2u << 0)

// Bits of TIM1, which drives the bridge.
#define TIM_CR1_CMS_DOWN   (1u << 5) ///< centre-aligned, mode 1
#define TIM_CR1_ARPE       (1u << 7)
#define TIM_CR2_MMS_OC4REF (7u << 4)
#define TIM_CCMR_OC1_PWM1  (6u << 4 | 1u << 3) ///< high below CCR1, with preload; odd channels
#define TIM_CCMR_OC2_PWM1  (6u << 12 | 1u << 11)
#define TIM_CCMR_OC4_PWM2  (7u << 12 | 1u << 11) ///< high from CCR4 on
#define TIM_CCER_LEG1      (5u << 0)             ///< CC1E, CC1NE
#define TIM_CCER_LEG2      (5u << 4)
#define TIM_CCER_LEG3      (5u << 8)
#define TIM_BDTR_LOCK3     (3u << 8)
#define TIM_BDTR_OSSI      (1u << 10)
#define TIM_BDTR_OSSR      (1u << 11)
#define TIM_BDTR_BKE       (1u << 12)
#define TIM_BDTR_BKP       (1u << 13)
#define TIM_BDTR_MOE       (1u << 15)

#define TIM_CR1_CEN  (1u << 0)
#define TIM_DIER_UIE (1u << 0)
#define TIM_SR_UIF   (1u << 0)
#define TIM_EGR_UG   (1u << 0)

// --- ADCs and DAC --------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t SR, CR1, CR2, SMPR1, SMPR2, JOFR1, JOFR2, JOFR3, JOFR4, HTR, LTR, SQR1, SQR2, SQR3, JSQR;
    reg_t JDR1, JDR2, JDR3, JDR4, DR;
} adc_t;

#define ADC1    ((adc_t *)0x40012000u)
#define ADC2    ((adc_t *)0x40012100u)
#define ADC_CCR (*(reg_t *)0x40012304u)

#define ADC_SR_EOC          (1u << 1)
#define ADC_SR_JEOC         (1u << 2)
#define ADC_CR1_EOCIE       (1u << 5)
#define ADC_CR1_JEOCIE      (1u << 7)
#define ADC_CR1_SCAN        (1u << 8)
#define ADC_CR2_ADON        (1u << 0)
#define ADC_CR2_CONT        (1u << 1)
#define ADC_CR2_JEXTSEL_T1  (1u << 16) ///< TIM1_TRGO
#define ADC_CR2_JEXTEN_RISE (1u << 20)
#define ADC_CR2_SWSTART     (1u << 30)
#define ADC_SMPR2_SMP0_56   (3u << 0)
#define ADC_SMPR2_SMP1_15   (1u << 3)
#define ADC_SMPR2_SMP2_15   (1u << 6)
#define ADC_SMPR2_SMP3_15   (1u << 9)
#define ADC_SMPR2_SMP4_15   (1u << 12)
#define ADC_SMPR2_SMP0_480  (7u << 0)
#define ADC_SMPR2_SMP1_480  (7u << 3)
#define ADC_SMPR2_SMP2_480  (7u << 6)
#define ADC_SMPR2_SMP3_480  (7u << 9)
#define ADC_CCR_ADCPRE_DIV4 (1u << 16)

typedef struct
{
    reg_t CR, SWTRIGR, DHR12R1;
} dac_t;

#define DAC ((dac_t *)0x40007400u)

#define DAC_CR_EN1   (1u << 0)
#define DAC_CR_BOFF1 (1u << 1)

// --- USART1 --------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t SR, DR, BRR, CR1, CR2, CR3, GTPR;
} usart_t;

#define USART1 ((usart_t *)0x40011000u)

#define USART_SR_PE      (1u << 0)
#define USART_SR_FE      (1u << 1)
#define USART_SR_NF      (1u << 2)
#define USART_SR_ORE     (1u << 3)
#define USART_SR_RXNE    (1u << 5)
#define USART_SR_TC      (1u << 6)
#define USART_SR_TXE     (1u << 7)
#define USART_CR1_RE     (1u << 2)
#define USART_CR1_TE     (1u << 3)
#define USART_CR1_RXNEIE (1u << 5)
#define USART_CR1_UE     (1u << 13)

// --- IWDG, the independent watchdog --------------------------------------------------------------------------------

typedef struct
{
    reg_t KR, PR, RLR, SR;
} iwdg_t;

#define IWDG ((iwdg_t *)0x40003000u)

#define IWDG_KR_START  0xccccu
#define IWDG_KR_ACCESS 0x5555u
#define IWDG_KR_RELOAD 0xaaaau
#define IWDG_SR_PVU    (1u << 0)
#define IWDG_SR_RVU    (1u << 1)

#endif
