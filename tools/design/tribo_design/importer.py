"""Reads a controller made by another tool: a JSON, CSV or MATLAB file with state space, zpk, transfer function or sections.

JSON   one object with the fields of one form, and sample_time_s when it is discrete:
       {"zeros": [..], "poles": [..], "k": 1.5}   complex roots as "-1+2j" or [re, im];  {"num": [..], "den": [..]};
       {"a": [[..]], "b": .., "c": .., "d": ..};  {"sos": [[b0, b1, b2, a0, a1, a2], ..], "g": 1, "sample_time_s": 0.001}
CSV    kind,re,im with a row each "zero", "pole", one "gain", and "sample_time_s" when discrete;
       or b0,b1,b2,a0,a1,a2 with a row a section (then the design's sample time is meant)
MAT    (up to version 7) the same fields: a b c d, or z p k, or num den, or sos and g; Ts when discrete
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .config import check_conjugates
from .reading import format_root, printable, read_rows, read_text
from .errors import InputError
from .exact import Ratio, state_space_response
from .zpk import Zpk

ORDER_MAX = 40
SECTIONS_MAX = 20
FIELDS_MAX = 100
NUMBER_MIN, NUMBER_MAX = 1e-100, 1e100  # range of the magnitude of a nonzero entry
RESPONSE_TOLERANCE = 1e-6  # relative difference between the accepted and the given response
INTEGRATOR = 1e-12  # rad/s times the sample time, below which a pole is taken for an integrator
FORMS = {"state space": ("a", "b", "c", "d"), "zpk": ("zeros", "poles", "k"), "transfer function": ("num", "den"), "sections": ("sos", "g")}
ALIASES = {"z": "zeros", "p": "poles", "gain": "k", "A": "a", "B": "b", "C": "c", "D": "d", "SOS": "sos", "G": "g", "Ts": "sample_time_s",
           "ts": "sample_time_s", "dt": "sample_time_s", "T": "sample_time_s", "numerator": "num", "denominator": "den"}


@dataclass(frozen=True)
class Imported:
    zpk: Zpk  # in s, or in d = z - 1
    form: str
    continuous: bool
    source: str

    def describe(self):
        return f"{printable(self.source)}, {self.form}, {'continuous' if self.continuous else 'discrete'}, order {self.zpk.order}"


def load_controller(path, design):
    """The controller and the SHA-256 of its file."""
    import hashlib

    path = Path(path)
    suffix = path.suffix.lower()
    readers = {".json": _from_json, ".csv": _from_csv, ".mat": _from_mat}
    if suffix not in readers:
        raise InputError(f"{path}: ends in {suffix or 'nothing'}; must be one of .json, .csv, .mat")
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    fields = readers[suffix](path, design)
    return _build(path, fields, design), hashlib.sha256(raw).hexdigest()


def _unique(path, pairs):
    if len(pairs) > FIELDS_MAX:
        raise InputError(f"{path}: has {len(pairs)} fields, at most {FIELDS_MAX}")
    fields = {}
    for name, value in pairs:
        if name in fields:
            raise InputError(f"{path}: {name[:40]}: is given twice")
        fields[name] = value
    return fields


def _from_json(path, design):
    text, _ = read_text(path)
    try:
        data = json.loads(text, parse_constant=float, object_pairs_hook=lambda pairs: _unique(path, pairs))
    except RecursionError:
        raise InputError(f"{path}: not a controller: nested too deeply") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path}:{error.lineno}: not JSON: {error.msg}") from None
    except ValueError as error:  # an integer with more digits than Python reads
        raise InputError(f"{path}: not a controller: {error}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: must be an object with the fields of one form")
    return data


def _from_csv(path, design):
    text, _ = read_text(path)
    rows = read_rows(path, text)
    head = [c.lower() for c in rows[0][1]]
    if head == ["b0", "b1", "b2", "a0", "a1", "a2"]:
        sos = []
        for line, row in rows[1:]:
            if len(row) != 6:
                raise InputError(f"{path}:{line}: must have 6 columns, found {len(row)}")
            sos.append([_cell(path, line, name, c) for name, c in zip(head, row)])
        return {"sos": sos, "sample_time_s": design.sample_time_s}
    if head != ["kind", "re", "im"]:
        raise InputError(f"{path}:{rows[0][0]}: the first row must be kind,re,im or b0,b1,b2,a0,a1,a2; found {','.join(head)[:60]}")
    fields = {"zeros": [], "poles": []}
    for line, row in rows[1:]:
        if len(row) not in (2, 3):
            raise InputError(f"{path}:{line}: must have 3 columns, found {len(row)}")
        kind, re = row[0].lower(), _cell(path, line, "re", row[1])
        im = _cell(path, line, "im", row[2]) if len(row) == 3 and row[2] else 0.0
        if kind in ("zero", "pole"):
            fields[kind + "s"].append(complex(re, im))
        elif kind in ("gain", "k", "sample_time_s"):
            key = "sample_time_s" if kind == "sample_time_s" else "k"
            if key in fields:
                raise InputError(f"{path}:{line}: {kind}: is given twice")
            if im:
                raise InputError(f"{path}:{line}: {kind}: value {row[2]!r}: must be real")
            fields[key] = re
        else:
            raise InputError(f"{path}:{line}: kind: value {row[0]!r}: must be one of zero, pole, gain, sample_time_s")
    return fields


def _cell(path, line, name, text):
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{path}:{line}: {name}: value {text!r}: must be a number") from None


def _from_mat(path, design):
    import scipy.io

    try:
        data = scipy.io.loadmat(path)
    except NotImplementedError:
        raise InputError(f"{path}: a MATLAB 7.3 file; save it with -v7") from None
    except Exception as error:  # noqa: BLE001 - scipy raises whatever a broken file leads it to
        raise InputError(f"{path}: not a MATLAB file: {str(error).splitlines()[0] if str(error) else type(error).__name__}") from None
    fields = {}
    for key, value in data.items():
        if key.startswith("__"):
            continue
        while isinstance(value, np.ndarray) and value.dtype == object and value.size == 1:
            value = value.ravel()[0]  # a cell, which tfdata and zpkdata return without the argument 'v'
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "biufc":
            raise InputError(f"{path}: {key}: must be numbers (save a, b, c, d or z, p, k, not a system object)")
        name = ALIASES.get(key, key)
        if name in ("zeros", "poles", "num", "den"):
            if value.ndim != 2 or min(value.shape, default=0) > 1:
                raise InputError(f"{path}: {key}: must be a vector (single input, single output), found {' x '.join(map(str, value.shape))}")
            value = value.ravel()
        if name in ("k", "g", "sample_time_s"):
            if value.size != 1:
                raise InputError(f"{path}: {key}: must be one number, found {' x '.join(map(str, value.shape))}")
            value = value.ravel()[0]
        fields[name] = value.tolist()
    return fields


def _build(path, data, design):
    fields = {}
    for key, value in data.items():
        name = ALIASES.get(key, key)
        if name in fields:
            raise InputError(f"{path}: {key}: is given twice")
        fields[name] = value
    known = {n for names in FORMS.values() for n in names} | {"sample_time_s", "name", "description"}
    for name in fields:
        if name not in known:
            raise InputError(f"{path}: {name}: there is no such field; the forms are " + "; ".join(f"{f}: {', '.join(n)}" for f, n in FORMS.items()))
    present = [f for f, names in FORMS.items() if any(n in fields for n in names)]
    if len(present) != 1:
        raise InputError(f"{path}: give exactly one form ({', '.join(FORMS)}); found {', '.join(present) or 'none'}")
    form = present[0]
    h = None
    if fields.get("sample_time_s") is not None:
        h = _real(path, "sample_time_s", fields["sample_time_s"])
        if h < 0 or (h == 0 and form == "sections"):
            raise InputError(f"{path}: sample_time_s: value {h:g}: must be more than 0 (leave it out, or 0, for continuous time)")
        h = h or None
    if form == "sections" and h is None:
        raise InputError(f"{path}: sample_time_s: is missing (sections are discrete)")
    if h is not None and abs(h - design.sample_time_s) > 1e-9 * design.sample_time_s:
        raise InputError(f"{path}: sample_time_s: value {h!r}: must be the design's, {design.sample_time_s!r}")
    builder = {"state space": _state_space, "zpk": _zpk, "transfer function": _transfer_function, "sections": _sections}[form]
    try:
        system, given = builder(path, fields, h is not None)
    except (OverflowError, ValueError) as error:
        raise InputError(f"{path}: its roots or gain are beyond what double precision holds ({error})") from None
    system = _with_integrator(system, design.sample_time_s)
    _check(path, system, h)
    _check_feedthrough(path, system, h)
    _check_response(path, system, given, h)
    return Imported(system, form, h is None, path.name)


def _with_integrator(system, h):
    """Moves a pole that only rounding separates from 0 to 0: it belongs to an integrator."""
    near = np.abs(system.poles) < INTEGRATOR / h
    return Zpk(system.zeros, np.where(near, 0.0, system.poles), system.gain) if np.any(near & (system.poles != 0)) else system


def _check_response(path, system, given, h):
    """Compares the accepted controller with the given one over the whole band."""
    size = np.abs(np.r_[system.poles, system.zeros])
    size = size[size > 0]
    low, high = (size.min(), size.max()) if len(size) else (1.0, 1.0)
    if h is None:
        omega = np.unique(np.r_[np.geomspace(low * 1e-2, high * 1e2, 80), size])
        points = at = 1j * omega
    else:
        omega = np.geomspace(min(low, 1e-3) * 1e-2, np.pi, 80)
        points = np.exp(1j * omega)
        at = points - 1  # exactly d: z is near 1 where it matters
    accepted, wanted = system(at), given(points)
    with np.errstate(all="ignore"):
        # Very close to a root, where the response vanishes or explodes, the result depends on the root's last digit only.
        by_rounding = 1e-14 * sum((abs(r) / np.abs(at - r) for r in np.r_[system.poles, system.zeros]), np.zeros(len(at)))
        bad = ~(np.abs(accepted - wanted) <= np.maximum(RESPONSE_TOLERANCE, np.nan_to_num(by_rounding, nan=np.inf)) * np.abs(wanted) + np.where(by_rounding > 1, np.inf, 0))
    if np.any(bad):
        i = int(np.argmax(bad))
        raise InputError(f"{path}: cannot be represented: at {omega[i] / (h or 1.0):.4g} rad/s the file's response is {wanted[i]:.6g}, that of its zeros, poles and gain {accepted[i]:.6g}")


def _check_feedthrough(path, system, h):
    """Of a K(z): the library's sections have b0."""
    ticks = system.relative_degree
    if h is not None and ticks > 0:
        power = f"^{ticks}" if ticks > 1 else ""
        raise InputError(f"{path}: K(z) is strictly proper, {ticks} more pole{'s' * (ticks > 1)} than zeros: its u waits {ticks} tick{'s' * (ticks > 1)} for r - y, and the library's sections answer "
                         f"at once. Give z{power} K(z), in MATLAB minreal(K * tf('z', Ts){power}): the same u {ticks} tick{'s' * (ticks > 1)} earlier. What your actuator really waits goes into plant.delay_s, "
                         f"{ticks * h:g} s for as much")


def _real(path, name, value):
    if isinstance(value, str):
        try:
            value = complex(value.replace(" ", "").replace("i", "j")) if "n" not in value.lower() else float(value)
        except ValueError:
            pass
    if isinstance(value, list) and len(value) == 2 and value[1] == 0 and not isinstance(value[1], bool):
        value = value[0]
    if isinstance(value, complex) and value.imag == 0:
        value = value.real
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{path}: {name}: value {str(value)[:40]!r}: must be a real number")
    try:
        value = float(value)
    except OverflowError:
        value = np.inf
    if not np.isfinite(value):
        raise InputError(f"{path}: {name}: value {value}: must be finite")
    if value and not NUMBER_MIN <= abs(value) <= NUMBER_MAX:
        raise InputError(f"{path}: {name}: value {value:g}: must be 0, or of a size within {NUMBER_MIN:g} and {NUMBER_MAX:g}")
    return value


def _vector(path, name, fields, allow_empty=False):
    value = fields.get(name)
    if value is None:
        raise InputError(f"{path}: {name}: is missing")
    if not isinstance(value, list):
        value = [value]
    if not value and not allow_empty:
        raise InputError(f"{path}: {name}: is empty")
    if len(value) > ORDER_MAX + 1:
        raise InputError(f"{path}: {name}: has {len(value)} entries, at most {ORDER_MAX + 1}")
    return value


def _roots(path, name, fields):
    roots = []
    for i, value in enumerate(_vector(path, name, fields, allow_empty=True) if name in fields else []):
        where = f"{name}[{i}]"
        if isinstance(value, list) and len(value) == 2:
            value = complex(_real(path, where, value[0]), _real(path, where, value[1]))
        elif isinstance(value, str):
            try:
                value = complex(value.replace(" ", "").replace("i", "j"))
            except ValueError:
                raise InputError(f"{path}: {where}: value {value[:40]!r}: must be a number, \"re+imj\" or [re, im]") from None
        elif not isinstance(value, complex):
            value = complex(_real(path, where, value))
        roots.append(complex(_real(path, where, value.real), _real(path, where, value.imag)))
    try:
        check_conjugates(roots, f"{name}:")
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    return np.array(roots, complex)


def _zpk(path, fields, discrete):
    if "k" not in fields:
        raise InputError(f"{path}: k: is missing")
    gain = _real(path, "k", fields["k"])
    zeros, poles = _roots(path, "zeros", fields), _roots(path, "poles", fields)
    if len(zeros) > len(poles):
        raise InputError(f"{path}: zeros: {len(zeros)} zeros and {len(poles)} poles: K is not proper")
    return (Zpk(zeros - 1, poles - 1, gain) if discrete else Zpk(zeros, poles, gain)), Zpk(zeros, poles, gain)


def _transfer_function(path, fields, discrete):
    parts = {}
    for name in ("num", "den"):
        values = _vector(path, name, fields)
        if any(isinstance(v, list) for v in values):
            if len(values) != 1:
                raise InputError(f"{path}: {name}: must be a vector (single input, single output)")
            values = values[0]
        parts[name] = np.trim_zeros(np.array([_real(path, f"{name}[{i}]", v) for i, v in enumerate(values)]), "f")
        if not len(parts[name]):
            raise InputError(f"{path}: {name}: must not be all 0")
    num, den = parts["num"], parts["den"]
    if len(num) > len(den):
        raise InputError(f"{path}: num: degree {len(num) - 1} over den's {len(den) - 1}: K is not proper")
    given = Ratio.of_polynomials(num, den)
    return (given.moved_to_delta() if discrete else given).zpk(), given


def _matrix(path, name, fields):
    value = fields.get(name)
    if value is None:
        raise InputError(f"{path}: {name}: is missing")
    if not isinstance(value, list):
        value = [[value]]
    elif not value:
        raise InputError(f"{path}: {name}: is empty")
    elif not any(isinstance(row, list) for row in value):
        value = [[v] for v in value] if name == "b" else [value]
    if len(value) > ORDER_MAX or (isinstance(value[0], list) and len(value[0]) > ORDER_MAX):
        raise InputError(f"{path}: {name}: at most {ORDER_MAX} rows and columns")
    if any(not isinstance(row, list) or len(row) != len(value[0]) for row in value) or not value or not value[0]:
        raise InputError(f"{path}: {name}: must be a matrix with rows of the same length")
    return np.array([[_real(path, f"{name}[{i}][{j}]", v) for j, v in enumerate(row)] for i, row in enumerate(value)])


def _state_space(path, fields, discrete):
    a, b, c = (_matrix(path, n, fields) for n in "abc")
    d = _matrix(path, "d", fields) if "d" in fields else np.zeros((1, 1))
    n = len(a)
    for name, matrix, shape in (("a", a, (n, n)), ("b", b, (n, 1)), ("c", c, (1, n)), ("d", d, (1, 1))):
        if matrix.shape != shape:
            raise InputError(f"{path}: {name}: must be {shape[0]} x {shape[1]} (single input, single output), found {' x '.join(map(str, matrix.shape))}")
    given = Ratio.of_state_space(a, b, c, d)
    return (given.moved_to_delta() if discrete else given).zpk(), lambda points: state_space_response(a, b, c, d, points)


def _sections(path, fields, discrete):
    rows = fields["sos"] if "sos" in fields else None
    if not isinstance(rows, list) or not rows:
        raise InputError(f"{path}: sos: must be rows of b0, b1, b2, a0, a1, a2")
    if not isinstance(rows[0], list):
        rows = [rows]
    if len(rows) > SECTIONS_MAX:
        raise InputError(f"{path}: sos: has {len(rows)} rows, at most {SECTIONS_MAX}")
    gain = _real(path, "g", fields["g"]) if "g" in fields else 1.0
    sections = []
    for i, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != 6:
            raise InputError(f"{path}: sos[{i}]: must have 6 entries b0, b1, b2, a0, a1, a2, found {len(row) if isinstance(row, list) else 1}")
        values = [_real(path, f"sos[{i}][{j}]", v) for j, v in enumerate(row)]
        if values[3] == 0:
            raise InputError(f"{path}: sos[{i}][3]: value 0: a0 must not be 0")
        if values[0] == 0:
            raise InputError(f"{path}: sos[{i}][0]: value 0: the library's sections need direct feedthrough, b0 not 0")
        sections.append(values)
    given = Ratio.of_sections(sections)
    system = given.without_common_delays().moved_to_delta().zpk()
    # In double a slow section's polynomials at z near 1 are differences of numbers 1e12 times as large: the reference is exact.
    return Zpk(system.zeros, system.poles, system.gain * gain), lambda points: gain * given(points)


def _check(path, system, h):
    if system.gain == 0 or not np.isfinite(system.gain):
        raise InputError(f"{path}: K is 0 at every frequency" if system.gain == 0 else f"{path}: K's gain is not finite")
    if h is None:
        bad = [p for p in system.poles if p.real > 1e-9 * abs(p)]
        on_axis = [p for p in system.poles if abs(p.real) <= 1e-9 * abs(p)]
        if bad:
            hint = ""
            if all(abs(p) <= 1 + 1e-9 for p in system.poles):
                hint = ". All its poles are within the unit circle: a discrete K needs its sample time as well, sample_time_s (in MATLAB: Ts = K.Ts, saved with the rest)"
            raise InputError(f"{path}: poles: {format_root(bad[0])} rad/s is in the right half plane: K is unstable, the library runs stable controllers only{hint}")
    else:
        # |z|^2 - 1 over 2 |d|: as above, so that the last bit of a root on the circle decides nothing.
        beyond = [(2 * p.real + abs(p) ** 2) / (2 * abs(p)) if abs(p) > 1e-12 else 0.0 for p in system.poles]
        bad = [1 + p for p, by in zip(system.poles, beyond) if by > 1e-9]
        on_axis = [p for p, by in zip(system.poles, beyond) if abs(by) <= 1e-9]
        if bad:
            raise InputError(f"{path}: poles: z = {bad[0]:.9g} is not inside the unit circle: K is unstable, the library runs stable controllers only")
    if len(on_axis) > 1 or any(p.imag for p in on_axis):
        raise InputError(f"{path}: poles: {', '.join(format_root(p if h is None else 1 + p) for p in on_axis)} on the stability boundary; the library accepts one integrator and no more")
