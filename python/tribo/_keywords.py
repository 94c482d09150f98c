"""The keywords of run and of each part. Made by python/keywords.py of the table of keys."""

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict


class RunKeys(TypedDict, total=False):
    amplitude_N: float
    attraction_N_per_s: float
    belief: float
    bias_N: float
    contact_N: float
    curve: Literal["never", "always", "rising", "relays"]
    dead_zone_deg_per_s: float
    deflection_deg: float
    delay_s: float
    description: str
    duration_s: float
    dwell_s: float
    elastic_ratio: float
    end_s: float
    fade_time_s: float
    fast_ratio: float
    file: str
    film_N_s_per_deg: float
    forgetting_per_N: float
    from_Hz: float
    full_scale_N: float
    gain: float
    high_N: float
    input_max_N: float
    jump_lead: float
    jump_time_s: float
    length_deg: float
    low_N: float
    memory_s: float
    method: Literal["paper", "feedforward", "off"]
    model: Literal["paper", "torque", "coulomb", "karnopp", "armstrong", "dahl", "bristle", "reset_integrator", "bliman_sorine", "lubricated", "lugre", "elasto_plastic", "leuven", "maxwell_slip", "servo_mx106", "servo_mx64", "servo_xl330", "servo_erob80"]
    noise_N: float
    noise_seed: int
    on: bool | Literal["no", "yes"]
    period_deg: float
    period_s: float
    phase: float
    pole_rad_per_s: float
    presliding_N: float
    quantisation_N: float
    quick_time_s: float
    ramp_s: float
    reversal_N: float
    sample_time_s: float
    scale_error: float
    sections: Sequence[Mapping[str, float]]
    seed: int
    sensor: Literal["force", "none"]
    sensor_pole_rad_per_s: float
    slow_share: float
    step_s: float
    stiction: float
    still_time_s: float
    stray_N: float
    sweep_s: float
    to_Hz: float
    transition: float
    trust: float
    turn_N: float
    u_max_N: float
    u_min_N: float
    usual_force_N: float


class LoopKeys(TypedDict, total=False):
    actuator_pole_rad_per_s: float
    belief: float
    damping_N_s_per_deg: float
    fade_time_s: float
    forgetting_per_N: float
    full_scale_N: float
    gain: float
    gravity_N: float
    inertia_N_s2_per_deg: float
    input_max_N: float
    jump_lead: float
    jump_time_s: float
    k_max: float
    k_min: float
    ki_per_s: float
    kind: Literal["paper", "pi", "z", "delta", "none"]
    kp: float
    m: float
    method: Literal["paper", "feedforward", "off"]
    negative_offset_N: float
    negative_slope: float
    offset_N: float
    on: bool | Literal["no", "yes"]
    presliding_N: float
    pulse_width_s: float
    quick_time_s: float
    reset_level: float
    reversal_N: float
    sample_time_s: float
    sections: Sequence[Mapping[str, float]]
    sensor: Literal["force", "none"]
    sensor_pole_rad_per_s: float
    set_level: float
    slope: float
    stiffness_N_per_deg: float
    still_time_s: float
    stray_N: float
    table: Sequence[Mapping[str, float]]
    trust: float
    turn_N: float
    u_max_N: float
    u_min_N: float
    usual_force_N: float
    v0_N_per_s: float


class FrictionKeys(TypedDict, total=False):
    damping_N_s_per_deg: float
    full_scale_N: float
    gravity_N: float
    inertia_N_s2_per_deg: float
    input_max_N: float
    k_max: float
    k_min: float
    m: float
    negative_offset_N: float
    negative_slope: float
    offset_N: float
    pulse_width_s: float
    reset_level: float
    sample_time_s: float
    set_level: float
    slope: float
    stiffness_N_per_deg: float
    table: Sequence[Mapping[str, float]]
    u_max_N: float
    u_min_N: float
    v0_N_per_s: float


class CompensatorKeys(TypedDict, total=False):
    damping_N_s_per_deg: float
    full_scale_N: float
    gravity_N: float
    inertia_N_s2_per_deg: float
    input_max_N: float
    k_max: float
    k_min: float
    m: float
    negative_offset_N: float
    negative_slope: float
    offset_N: float
    pulse_width_s: float
    reset_level: float
    sample_time_s: float
    set_level: float
    slope: float
    stiffness_N_per_deg: float
    table: Sequence[Mapping[str, float]]
    u_max_N: float
    u_min_N: float
    v0_N_per_s: float


class GuardKeys(TypedDict, total=False):
    fade_time_s: float
    full_scale_N: float
    input_max_N: float
    on: bool | Literal["no", "yes"]
    quick_time_s: float
    sample_time_s: float
    stray_N: float
    turn_N: float
    u_max_N: float
    u_min_N: float


class FeedForwardKeys(TypedDict, total=False):
    actuator_pole_rad_per_s: float
    damping_N_s_per_deg: float
    forgetting_per_N: float
    full_scale_N: float
    gravity_N: float
    inertia_N_s2_per_deg: float
    input_max_N: float
    jump_lead: float
    jump_time_s: float
    k_max: float
    k_min: float
    m: float
    negative_offset_N: float
    negative_slope: float
    offset_N: float
    presliding_N: float
    pulse_width_s: float
    reset_level: float
    reversal_N: float
    sample_time_s: float
    sensor_pole_rad_per_s: float
    set_level: float
    slope: float
    stiffness_N_per_deg: float
    still_time_s: float
    table: Sequence[Mapping[str, float]]
    trust: float
    u_max_N: float
    u_min_N: float
    v0_N_per_s: float
