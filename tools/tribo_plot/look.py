"""The one table of colours: a signal has the same colour in every picture and report, and so have methods, directions and steps of a design.

Colours of Okabe and Ito and of Tol, which remain apart for colour-blind readers. Nothing but names: any Python can import it.
"""

# A signal by its column: what it is called and its colour.
SIGNALS = {
    "r_N": ("reference r", "#000000"),
    "F_N": ("force F", "#0072B2"),
    "y_N": ("measured y", "#56B4E9"),
    "F_hat_N": ("F of the model", "#332288"),
    "error": ("r − F", "#D55E00"),
    "residual_N": ("n − f", "#D55E00"),
    "u_N": ("command u", "#009E73"),
    "controller_N": ("controller's part", "#E69F00"),
    "friction_term_N": ("the compensation's part", "#CC79A7"),
    "n_N": ("net force n", "#8C564B"),
    "f_N": ("friction of the plant", "#767676"),
    "f_hat_N": ("friction as believed", "#CC79A7"),
    "L_N": ("breakaway L", "#882255"),
    "breakaway_positive_N": ("L learned, positive", "#882255"),
    "breakaway_negative_N": ("L learned, negative", "#999933"),
    "plant_L_N": ("L of the plant", "#767676"),
    "Q1": ("Q1", "#CC6677"),
    "Q2": ("Q2", "#6699CC"),
    "Q": ("Q", "#117733"),
    "state": ("state", "#332288"),
    "fault": ("fault", "#D55E00"),
    "late_us": ("late", "#E69F00"),
    "step_us": ("own work", "#009E73"),
    "x_deg": ("position x", "#999933"),
    "w_deg_per_s": ("speed w", "#117733"),
}


def colour(signal):
    return SIGNALS[signal][1]


# Where one signal of several runs is compared, a colour is a run's method ...
WITHOUT = "#D55E00"
PAPER = "#0072B2"
FEEDFORWARD = "#009E73"

# ... or the direction of force or motion ...
RISES = "#882255"
FALLS = "#999933"
WAYS = {1: RISES, -1: FALLS}

# ... or a step from a design to its coefficients.
STAGES = {"full": "#999999", "reduced": "#56B4E9", "discrete": "#D55E00", "f32": "#000000", "q31": "#009E73"}

# A measurement, and what a model makes of it.
MEASURED = "#56B4E9"
MODEL = "#000000"
DIFFERENCE = "#D55E00"

# Zero lines, levels, limits.
GUIDE = "#767676"
WISH = "#CC79A7"
GRID = "#E4E4E4"

# Of matplotlib, for all pictures.
STYLE = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans",
    "grid.color": GRID,
    "legend.frameon": False,
    "lines.solid_joinstyle": "round",
    "svg.fonttype": "path",
    "svg.hashsalt": "tribo",
}


# Runs on top of each other: the first as it is, one beneath it lighter and wider, one above it darker and broken, one below all.
# Part and end of the mixture with the signal's colour, width of the line, dashes, order.
RUNS = ((0.0, 255, 1.1, None, 2), (0.6, 255, 2.6, None, 1), (0.5, 0, 1.0, (4, 1.5), 3), (0.8, 255, 4.2, None, 0))


def shade(colour, run):
    """Returns the colour of a signal in one of several runs."""
    part, end = RUNS[run % len(RUNS)][:2]
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(value + part * (end - value)):02X}" for value in parts)
