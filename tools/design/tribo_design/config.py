"""DESIGN.yaml: what is allowed in it, and errors that name file, line, field, value and range."""

import math
import re
from typing import Annotated, Literal, Optional

import numpy as np
import ruamel.yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, field_validator, model_validator

from .errors import InputError
from .exact import Ratio
from .reading import format_root, parse_yaml, read_text
from .zpk import Zpk

ROOT_MAX = 1e12  # rad/s
GAIN_MAX = 1e12
COEFFICIENT_MIN, COEFFICIENT_MAX = 1e-60, 1e60
ORDER_MAX = 20
DESIGN_SIZE_MAX = 200_000
DELAY_TICKS_MAX = 40
OTHER_NUMBER = re.compile(r"[-+]?(0[xob]\w+|\.?\d[\d.eE+-]*_[\d_.eE+-]*)")  # of YAML or Python, e.g. 0x10 and 1_000


def _number(value):
    """YAML 1.1 reads 20e-4 as text: take it as the number it is."""
    if isinstance(value, bool):
        raise ValueError("must be a number")
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            raise ValueError("must be a number") from None
    if isinstance(value, (int, float)):
        try:
            value = float(value)
        except OverflowError:
            value = math.inf
        if not math.isfinite(value):
            raise ValueError("must be finite")
        return value
    raise ValueError("must be a number")


def _root(value):
    if isinstance(value, str):
        text = re.sub(r"\s+", "", value).replace("i", "j")
        try:
            value = complex(text)
        except ValueError:
            raise ValueError("must be a number or a complex number like -139+203j") from None
    if isinstance(value, bool) or not isinstance(value, (int, float, complex)):
        raise ValueError("must be a number or a complex number like -139+203j")
    try:
        value = complex(value)
    except OverflowError:
        value = complex(math.inf)
    if not (math.isfinite(value.real) and math.isfinite(value.imag)):
        raise ValueError("must be finite")
    if not abs(value) <= ROOT_MAX:
        raise ValueError(f"must be within {ROOT_MAX:g} rad/s of 0")
    return value


def _coefficient(value):
    value = _number(value)
    if value and not COEFFICIENT_MIN <= abs(value) <= COEFFICIENT_MAX:  # so that products of squares do not overflow
        raise ValueError(f"must be 0, or of a size within {COEFFICIENT_MIN:g} and {COEFFICIENT_MAX:g}")
    return value


Number = Annotated[float, BeforeValidator(_number)]
Coefficient = Annotated[float, BeforeValidator(_coefficient)]
Root = Annotated[complex, BeforeValidator(_root)]
Positive = Annotated[Number, Field(gt=0, le=GAIN_MAX)]
Filled = Annotated[str, Field(min_length=1)]


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", arbitrary_types_allowed=True, frozen=True)


def check_conjugates(roots, what):
    left = [r for r in roots if r.imag != 0]
    while left:
        root = left.pop()
        twin = next((r for r in left if abs(r - root.conjugate()) <= 1e-9 * abs(root)), None)
        if twin is None:
            raise ValueError(f"{what} {format_root(root)} has no complex conjugate: complex roots come in pairs")
        left.remove(twin)


class System(Strict):
    """A system in one of the forms: {gain|k, zeros, poles}, {num, den}, {a, b, c, d}, or a plain number."""

    gain: Optional[Coefficient] = None  # steady-state gain
    k: Optional[Coefficient] = None  # gain of the zpk form, the ratio of the leading coefficients
    zeros: Annotated[list[Root], Field(max_length=ORDER_MAX)] = []
    poles: Annotated[list[Root], Field(max_length=ORDER_MAX)] = []
    num: Optional[Annotated[list[Coefficient], Field(min_length=1, max_length=ORDER_MAX + 1)]] = None
    den: Optional[Annotated[list[Coefficient], Field(min_length=1, max_length=ORDER_MAX + 1)]] = None
    a: Optional[list[list[Coefficient]]] = None
    b: Optional[list[list[Coefficient]]] = None
    c: Optional[list[list[Coefficient]]] = None
    d: Optional[list[list[Coefficient]]] = None

    @model_validator(mode="before")
    @classmethod
    def _from_number(cls, value):
        if isinstance(value, (int, float, str)) and not isinstance(value, bool):
            return {"k": value}
        if not isinstance(value, dict):
            raise ValueError("must be a number, or one of the forms {gain, zeros, poles}, {num, den}, {a, b, c, d}")
        value = dict(value)
        for name in ("b", "c", "d", "a"):  # plain lists and numbers for single-input, single-output matrices
            entry = value.get(name)
            if isinstance(entry, (int, float, str)) and not isinstance(entry, bool):
                value[name] = [[entry]]
            elif isinstance(entry, list) and entry and not any(isinstance(e, list) for e in entry):
                value[name] = [[e] for e in entry] if name == "b" else [entry]
        return value

    @model_validator(mode="after")
    def _one_form(self):
        forms = []
        if self.gain is not None or self.k is not None or self.zeros or self.poles:
            forms.append("zpk")
        if self.num is not None or self.den is not None:
            forms.append("tf")
        if any(m is not None for m in (self.a, self.b, self.c, self.d)):
            forms.append("ss")
        if len(forms) != 1:
            raise ValueError("give exactly one of the forms {gain, zeros, poles}, {num, den}, {a, b, c, d}"
                             + (f"; found {' and '.join(forms)}" if forms else ""))
        getattr(self, f"_check_{forms[0]}")()
        return self

    def _check_zpk(self):
        if (self.gain is None) == (self.k is None):
            raise ValueError("give either gain (steady state) or k (leading coefficients), not both")
        check_conjugates(self.zeros, "zeros:")
        check_conjugates(self.poles, "poles:")
        if self.gain is not None and any(r == 0 for r in [*self.zeros, *self.poles]):
            raise ValueError("gain is the steady-state gain; with a root at 0 give k instead")

    def _check_tf(self):
        if self.num is None or self.den is None:
            raise ValueError("a transfer function needs num and den")
        if not any(self.den):
            raise ValueError("den must not be all 0")

    def _check_ss(self):
        if self.a is None or self.b is None or self.c is None:
            raise ValueError("a state-space form needs a, b and c (d is 0 when left out)")
        n = len(self.a)
        if not 1 <= n <= ORDER_MAX:
            raise ValueError(f"a: 1 to {ORDER_MAX} rows, found {n}")
        for name, rows, columns in (("a", n, n), ("b", n, 1), ("c", 1, n), ("d", 1, 1)):
            matrix = getattr(self, name)
            if matrix is None:
                continue
            shape = f"{len(matrix)} x {'/'.join(sorted({str(len(row)) for row in matrix}))}"
            if len(matrix) != rows or any(len(row) != columns for row in matrix):
                raise ValueError(f"{name}: must be {rows} x {columns} (single input, single output), found {shape}")

    @property
    def form(self):
        return "tf" if self.num is not None else "ss" if self.a is not None else "zpk"

    def matrices(self):
        d = self.d if self.d is not None else [[0.0]]
        return tuple(np.array(m, float) for m in (self.a, self.b, self.c, d))

    def zpk(self):
        """Zeros, poles and gain; the caller has to see to hidden modes of a state-space form first."""
        if self.form == "zpk":
            system = Zpk(self.zeros, self.poles, 1.0)
            if not (self.gain if self.gain is not None else self.k):
                return Zpk(self.zeros, self.poles, 0.0)
            return system.with_value_at(0.0, self.gain) if self.gain is not None else Zpk(self.zeros, self.poles, self.k)
        if self.form == "tf":
            return Ratio.of_polynomials(self.num, self.den).zpk()
        return Ratio.of_state_space(*self.matrices()).zpk()


SPREAD = re.compile(r"^(.*?)\s*(?:±|\+-|\+/-)\s*(.*?)\s*%\s*$")


def _spread(value):
    """"-55 ± 10 %" as the value and its percentage."""
    found = SPREAD.match(value) if isinstance(value, str) else None
    return (value, 0.0) if found is None else (found.group(1), found.group(2))


class Plant(System):
    """A system, its dead time, and how far each of its numbers may be off: `-55 ± 10 %` is poles and poles_percent in one.

    The percentage of a complex pair is that of its size, its damping ratio kept.
    """

    delay_s: Annotated[Number, Field(ge=0, le=100)] = 0.0
    gain_percent: Annotated[Number, Field(ge=0, lt=100)] = 0.0
    delay_percent: Annotated[Number, Field(ge=0, le=100)] = 0.0
    zeros_percent: list[Annotated[Number, Field(ge=0, lt=100)]] = []
    poles_percent: list[Annotated[Number, Field(ge=0, lt=100)]] = []

    @model_validator(mode="before")
    @classmethod
    def _from_spreads(cls, value):
        value = cls._from_number(value)
        for name, percent in (("gain", "gain_percent"), ("k", "gain_percent"), ("delay_s", "delay_percent")):
            plain, spread = _spread(value.get(name))
            if spread:
                if percent in value:
                    raise ValueError(f"{percent}: is given twice")
                value.update({name: plain, percent: spread})
        for name in ("zeros", "poles"):
            both = [_spread(v) for v in value[name]] if isinstance(value.get(name), list) else []
            if any(spread for _, spread in both):
                if f"{name}_percent" in value:
                    raise ValueError(f"{name}_percent: is given twice")
                value.update({name: [v for v, _ in both], f"{name}_percent": [spread for _, spread in both]})
        return value

    @model_validator(mode="after")
    def _spreads_fit(self):
        for name in ("zeros", "poles"):
            if getattr(self, f"{name}_percent") and len(getattr(self, f"{name}_percent")) != len(getattr(self, name)):
                raise ValueError(f"{name}_percent: must have as many entries as {name}, {len(getattr(self, name))}")
        if self.form != "zpk" and self.gain_percent:
            raise ValueError("gain_percent: goes with the form {gain, zeros, poles} only")
        return self


class Wishes(Strict):
    """Weights in a user's words: wp = (s/peak + bandwidth)/(s + bandwidth steady_error), wu = 1/u_per_r, wT rising from `rolloff` on."""

    bandwidth_rad_s: Positive
    peak: Annotated[Number, Field(gt=1, le=10)] = 2.0  # of |S|
    steady_error: Annotated[Number, Field(gt=0, lt=0.5)] = 1e-3  # r - y at rest, of r
    u_per_r: Positive  # largest |u| for |r| = 1, at any frequency
    rolloff_rad_s: Optional[Positive] = None  # above it T falls; eight times the bandwidth if left out

    def weights(self):
        w, corner = self.bandwidth_rad_s, self.rolloff_rad_s if self.rolloff_rad_s is not None else 8 * self.bandwidth_rad_s
        return {"wp": {"num": [1 / self.peak, w], "den": [1, w * self.steady_error]}, "wu": 1 / self.u_per_r,
                "wT": {"num": [1, corner / self.peak], "den": [1e-2, corner]}}


class Weights(Strict):
    wp: System
    wu: System
    wT: Optional[System] = None
    wGS: Optional[System] = None  # on G S: what friction, a force at the plant's input, does to y
    wishes: Optional[Wishes] = None

    @model_validator(mode="before")
    @classmethod
    def _from_wishes(cls, value):
        if isinstance(value, dict) and "wishes" in value:
            made = Wishes.model_validate(value["wishes"]).weights() if isinstance(value["wishes"], dict) else {}
            return {**made, **value}  # an explicit weight overrides the one made from the requirements
        return value

    def named(self):
        return {name: getattr(self, name) for name in ("wp", "wu", "wT", "wGS") if getattr(self, name) is not None}


class Synthesis(Strict):
    domain: Literal["sampled", "continuous"] = "sampled"  # sampled: the synthesis includes hold and delay
    structure: Literal["full", "pi", "pid", "lead-lag"] = "full"
    off_optimum_percent: Optional[Annotated[Number, Field(ge=0, le=100)]] = None  # percent of gamma; None: 0, or 1 if 0 fails
    time_limit_s: Annotated[Number, Field(ge=1, le=3600)] = 60.0
    gamma_max: Annotated[Number, Field(gt=0, le=1e6)] = 5.0


class Reduction(Strict):
    method: Literal["modal", "balanced", "auto"] = "auto"
    fast_mode_multiple: Annotated[Number, Field(ge=0.1, le=1e6)] = 1.0  # of the Nyquist frequency
    cancellation_percent: Annotated[Number, Field(ge=0, le=50)] = 1.0  # distance between a pole and a zero, relative to the pole
    order_max: Annotated[int, Field(ge=1, le=8)] = 8
    digits: Annotated[int, Field(ge=3, le=12)] = 5  # significant digits that the reduced design keeps


class Discretisation(Strict):
    method: Literal["tustin", "tustin-prewarped", "zoh", "matched"] = "tustin"
    prewarp_rad_s: Optional[Positive] = None

    @model_validator(mode="after")
    def _prewarp(self):
        if (self.method == "tustin-prewarped") != (self.prewarp_rad_s is not None):
            raise ValueError("prewarp_rad_s goes with method tustin-prewarped, and only with it")
        return self


class FixedPoint(Strict):
    full_scale_n: Annotated[Number, Field(ge=1e-3, le=1e6)] = 2.0  # the force that is 2^31
    u_max_n: Optional[Annotated[Number, Field(gt=0, le=1e6)]] = None  # limit of the controller's output in both directions; default: full scale

    @model_validator(mode="after")
    def _within(self):
        if self.u_max_n is not None and self.u_max_n > self.full_scale_n:
            raise ValueError(f"u_max_n: value {self.u_max_n:g}: must be at most full_scale_n, {self.full_scale_n:g}")
        return self

    @property
    def limit_n(self):
        return self.full_scale_n if self.u_max_n is None else self.u_max_n


class Ramp(Strict):
    rate_n_per_s: Annotated[Number, Field(gt=0, le=1e9)] = 1.0
    duration_s: Annotated[Number, Field(gt=0, le=1e9)] = 10.0


Percent = Annotated[Number, Field(ge=0, le=1e6)]


class Limits(Strict):
    """Limits on how much worse one step may make the loop; None means no limit."""

    gamma_percent: Optional[Percent] = None
    max_s_percent: Optional[Percent] = None
    max_t_percent: Optional[Percent] = None
    max_ks_percent: Optional[Percent] = None
    gain_margin_percent: Optional[Percent] = None
    phase_margin_deg: Optional[Annotated[Number, Field(ge=0, le=360)]] = None
    delay_margin_percent: Optional[Percent] = None
    bandwidth_percent: Optional[Percent] = None
    ramp_error_percent: Optional[Percent] = None
    low_gain_percent: Optional[Percent] = None
    max_gs_percent: Optional[Percent] = None
    disk_margin_percent: Optional[Percent] = None
    slowest_pole_percent: Optional[Percent] = None


class Floor(Strict):
    """Limits that the loop must meet after every step, independent of the step before."""

    gain_margin_min: Annotated[Number, Field(ge=1, le=1e6)] = 2.0
    phase_margin_min_deg: Annotated[Number, Field(ge=0, le=180)] = 30.0


class AllLimits(Strict):
    """The limits of each step relative to the step before; `total` compares the last step with the first."""

    reduced: Limits = Limits(gamma_percent=1, max_s_percent=1, phase_margin_deg=1, ramp_error_percent=1,
                             bandwidth_percent=2, low_gain_percent=1)
    discrete: Limits = Limits(gamma_percent=10, max_s_percent=10, phase_margin_deg=10, ramp_error_percent=1,
                              bandwidth_percent=25, low_gain_percent=1)
    f32: Limits = Limits(gamma_percent=0.1, max_s_percent=0.1, max_t_percent=0.1, max_ks_percent=0.1,
                         phase_margin_deg=0.1, gain_margin_percent=0.1, ramp_error_percent=0.1, low_gain_percent=0.1)
    q31: Limits = Limits(gamma_percent=0.1, max_s_percent=0.1, max_t_percent=0.1, max_ks_percent=0.1,
                         phase_margin_deg=0.1, gain_margin_percent=0.1, ramp_error_percent=0.1, low_gain_percent=0.1)
    total: Limits = Limits(gamma_percent=15, phase_margin_deg=15)
    floor: Floor = Floor()


class Design(Strict):
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,30}$")]
    description: Annotated[str, Field(max_length=2000)] = ""
    include_folder: Annotated[str, Field(pattern=r"^([A-Za-z0-9_]+/)*$")] = ""  # how the C source includes the header, e.g. "tribo/"
    sample_time_s: Annotated[Number, Field(ge=1e-6, le=10)]
    computation_delay_s: Annotated[Number, Field(ge=0, le=10)] = 0.0
    plant: Plant
    weights: Optional[Weights] = None
    synthesis: Synthesis = Synthesis()
    reduction: Reduction = Reduction()
    discretisation: Discretisation = Discretisation()
    fixed_point: FixedPoint = FixedPoint()
    ramp: Ramp = Ramp()
    limits: AllLimits = AllLimits()

    @model_validator(mode="after")
    def _whole_delay(self):
        if self.plant.delay_s > DELAY_TICKS_MAX * self.sample_time_s:
            raise ValueError(f"plant.delay_s: value {self.plant.delay_s:g}: must be at most {DELAY_TICKS_MAX} sample times, {DELAY_TICKS_MAX * self.sample_time_s:g} s")
        if self.plant.delay_s and self.synthesis.domain == "continuous":
            raise ValueError("plant.delay_s: a dead time goes with synthesis.domain sampled only")
        if self.synthesis.structure != "full" and self.synthesis.domain == "continuous":
            raise ValueError("synthesis.structure: other structures than full go with synthesis.domain sampled only")
        return self

    @property
    def delay_s(self):
        """The delay from reading y to the response in y: computation and dead time, without the hold."""
        return self.computation_delay_s + self.plant.delay_s

    @field_validator("computation_delay_s")
    @classmethod
    def _delay(cls, value, info):
        h = info.data.get("sample_time_s")
        if h is not None and value > 2 * h:
            raise ValueError(f"must be within two sample times, {2 * h:g} s")
        return value

    @model_validator(mode="after")
    def _prewarp_below_nyquist(self):
        w = self.discretisation.prewarp_rad_s
        if w is not None and not w < math.pi / self.sample_time_s:
            raise ValueError(f"discretisation.prewarp_rad_s: must be below the Nyquist frequency, "
                             f"{math.pi / self.sample_time_s:.6g} rad/s")
        return self


def load_design(path):
    """The validated design of a YAML file and the file's SHA-256."""
    text, digest = read_text(path)
    return parse_design(text, path), digest


def parse_design(text, path="DESIGN.yaml"):
    data, lines = load_yaml(text, path)
    if not isinstance(data, dict):
        raise InputError(f"{path}:1: must be a mapping with name, sample_time_s, plant and weights")
    return validate(Design, data, path, lines)


def validate(model, data, path, lines=None):
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError("\n".join(_explain(e, data, path, lines or {}) for e in error.errors())) from None


def _explain(error, data, path, lines):
    where = tuple(p for p in error["loc"])
    while where and where not in lines and lines:
        where = where[:-1]
    line = lines.get(where, 1)
    name = ""
    for part in error["loc"]:
        name += f"[{part}]" if isinstance(part, int) else f".{part}" if name else str(part)
    text = error["msg"].removeprefix("Value error, ")
    kind = error["type"]
    place = f"{path}:{line}: " if lines else f"{path}: "
    if kind == "missing":
        return f"{place}{name}: is missing"
    if kind == "extra_forbidden":
        parent = ".".join(str(p) for p in error["loc"][:-1])
        return f"{place}{name}: there is no such field" + (f" in {parent}" if parent else "")
    context = error.get("ctx", {})
    bounds = [f"{word} {context[key]:g}" for key, word in
              (("gt", "more than"), ("ge", "at least"), ("lt", "less than"), ("le", "at most")) if key in context]
    if bounds:
        text = "must be " + " and ".join(bounds)
    elif kind == "literal_error":
        text = f"must be one of {context['expected']}"
    elif kind == "string_pattern_mismatch":
        text = "must start with a lower-case letter and have only lower-case letters, digits and _, at most 31"
    elif text.startswith("Input should be"):
        text = "must be" + text.removeprefix("Input should be")
    value = repr(error.get("input"))
    value = value if len(value) <= 60 else value[:57] + "..."
    return f"{place}{name or 'file'}: value {value}: {text}" if name else f"{place}{text}"


def load_yaml(text, path):
    """Returns the data, and the line of every field by its path. Refuses duplicate keys, aliases, tags and deep nesting."""
    if len(text) > DESIGN_SIZE_MAX:
        raise InputError(f"{path}: too large: {len(text)} characters, at most {DESIGN_SIZE_MAX}")
    data = parse_yaml(text, path, "rt")
    if data is None:
        raise InputError(f"{path}:1: is empty")
    for token in ruamel.yaml.YAML(pure=True).scan(text):
        if isinstance(token, ruamel.yaml.tokens.ScalarToken) and OTHER_NUMBER.fullmatch(token.value):
            raise InputError(f"{path}:{token.start_mark.line + 1}: value {token.value}: must be a decimal number, as tribo-sim reads it")
    lines = {(): 1}
    seen = set()

    def plain(value, where):
        line = lines[where]
        anchor = getattr(value, "anchor", None)
        if id(value) in seen or len(where) > 12 or (anchor is not None and anchor.value) or isinstance(value, ruamel.yaml.comments.TaggedScalar):
            raise InputError(f"{path}:{line}: anchors, tags and deep nesting are not supported")
        if isinstance(value, dict):
            seen.add(id(value))
            for key in value:
                lines[(*where, key)] = value.lc.data[key][0] + 1 if key in value.lc.data else line
                if not isinstance(key, str):
                    raise InputError(f"{path}:{lines[(*where, key)]}: a field's name must be plain text")
            return {str(key): plain(item, (*where, key)) for key, item in value.items()}
        if isinstance(value, list):
            seen.add(id(value))
            for i in range(len(value)):
                lines[(*where, i)] = value.lc.data[i][0] + 1
            return [plain(item, (*where, i)) for i, item in enumerate(value)]
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    return plain(data, ()), lines
