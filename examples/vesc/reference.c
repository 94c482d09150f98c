// The reference; replace it with yours. Here it is a potentiometer on ADC2: 0 to 3.3 V are 0 to 1 N.

#include "vesc_c_if.h"

float reference_n(void);

float reference_n(void)
{
    return VESC_IF->io_read_analog(VESC_PIN_ADC2) / 3.3f;
}
