// The library's sentences.

#include "tribo/axis_f32.h"
#include "tribo/joint_f32.h"

const char *tribo_sys_axis_warning(uint32_t *warnings);
const char *tribo_sys_status_text(int32_t status);
const char *tribo_sys_joint_cause_text(int32_t cause);

const char *tribo_sys_axis_warning(uint32_t *warnings)
{
    return tribo_axis_warning(warnings);
}

const char *tribo_sys_status_text(int32_t status)
{
    return tribo_status_text((tribo_status_t)status);
}

const char *tribo_sys_joint_cause_text(int32_t cause)
{
    return tribo_joint_cause_text((tribo_joint_cause_t)cause);
}
