// Makes the method and the guard that a loop's config names. This text serves both arithmetics and is included after
// loop_f32.h or loop_q31.h.

/// Makes one of them. Returns TRIBO_OK if the config names none.
static tribo_status_t make_part(const tribo_loop_part_t             *part,
                                const tribo_force_loop_f32_config_t *config,
                                float                                full_scale_n,
                                loop_params_t                       *made)
{
    if (part->make_f32 == NULL && part->make_q31 == NULL)
    {
        return TRIBO_OK;
    }
    return part->TYPED(make) != NULL ? part->TYPED(make)(part, config, full_scale_n, made) : TRIBO_ERR_PART;
}

/// Completes `made` by both.
static tribo_status_t make_parts(const tribo_force_loop_f32_config_t *config, float full_scale_n, loop_params_t *made)
{
    const tribo_status_t status = make_part(&config->method, config, full_scale_n, made);
    return status == TRIBO_OK ? make_part(&config->guard.part, config, full_scale_n, made) : status;
}
