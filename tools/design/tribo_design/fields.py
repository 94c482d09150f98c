"""The fields of DESIGN.yaml, as `tribo-design synthesize --help` lists them; config.py checks them."""

FIELDS = """The order of K is the lowest at which the loop stays within limits.reduced and the library takes the sections. One integrator in the
plant is supported (sampled). Fields: unit or range; default; meaning

name
    lower case; goes into file and macro names
description
    up to 2000 characters
include_folder
    ends in /; default none; before the header's name in the C source
sample_time_s
    1e-6 to 10 s; of the loop
computation_delay_s
    0 to 2 sample times; default 0; from reading y to u at the output; the hold is always counted
plant, weights.wp, .wu, .wT, .wGS
    rad/s; {gain, zeros, poles} (steady gain), {k, zeros, poles}, {num, den}, {a, b, c, d}, or a number; wT and wGS may
    be left out
plant.gain_percent, .zeros_percent, .poles_percent, .delay_percent
    how far each number may be off; `gain: 1.4 ± 5 %` and `poles: [-12 ± 10 %, ...]` say the same
plant.delay_s
    0 to 40 sample times; default 0; dead time; sampled only
weights.wishes
    rad/s, -; {bandwidth_rad_s, u_per_r, peak: 2, steady_error: 1e-3, rolloff_rad_s} instead of wp, wu and wT; a weight
    given as well replaces its own
synthesis.domain
    sampled, continuous; default sampled; sampled: designs for the sampled loop, with hold and delay in it; continuous: the
    paper's way, where they are only checked
synthesis.structure
    full, pi, pid, lead-lag; default full; structured synthesis by the same weights; the report compares its gamma with
    the full order's
synthesis.off_optimum_percent
    0 to 100 %; default 0, then 1; gamma given away, as K has a pole near infinity at the optimum
synthesis.time_limit_s
    1 to 3600 s; default 60; of the solver
synthesis.gamma_max
    default 5; above it, the weights contradict each other
reduction.method
    modal, balanced, auto; default auto; modal: modes beyond Nyquist, then near-cancellations; balanced truncation; or
    both
reduction.fast_mode_multiple
    of Nyquist; default 1; what "beyond" means
reduction.cancellation_percent
    0 to 50 %; default 1; how near a pole and a zero must be
reduction.order_max, .digits
    1 to 8, 3 to 12; default 8, 5
discretisation.method
    tustin, tustin-prewarped, zoh, matched; default tustin; of continuous designs and imports; prewarp_rad_s with the
    second
fixed_point.full_scale_n, .u_max_n
    N; default 2, full scale; the force that is 2^31; the output's limit of either sign
ramp.rate_n_per_s, .duration_s
    N/s, s; default 1, 10; of the table's ramp error
limits.reduced, .discrete, .f32, .q31
    how much worse a step may make each column of the table; what is left out has no limit. gamma_percent, max_s_percent,
    max_t_percent, max_ks_percent, max_gs_percent, gain_margin_percent, phase_margin_deg, delay_margin_percent,
    disk_margin_percent, bandwidth_percent, ramp_error_percent, low_gain_percent, slowest_pole_percent
limits.total
    the same, the last step against the first
limits.floor
    default 2, 30°; gain_margin_min, phase_margin_min_deg, at every step
"""
