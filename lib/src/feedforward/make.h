// Makes the feed-forward in the set-up of a loop whose config names it. This text serves both arithmetics and is included
// after `init_for`, which initialises params for the loop's config.

tribo_status_t FEEDFORWARD(make)(const tribo_loop_part_t             *part,
                                 const tribo_force_loop_f32_config_t *loop,
                                 float                                full_scale_n,
                                 loop_params_t                       *made)
{
    params_t *const                             params = (params_t *)part->params;
    const tribo_feedforward_f32_config_t *const config = (const tribo_feedforward_f32_config_t *)part->config;

    const tribo_status_t status = init_for(params, config, loop, full_scale_n, made);
    if (status == TRIBO_OK)
    {
        FEEDFORWARD(set_method)(params);
        made->method = &params->method;
    }
    return status;
}

tribo_loop_part_t FEEDFORWARD(use)(params_t *params, const tribo_feedforward_f32_config_t *config)
{
    tribo_loop_part_t part = {.config = config, .params = params};
    part.TYPED(make)       = FEEDFORWARD(make);
    return part;
}
