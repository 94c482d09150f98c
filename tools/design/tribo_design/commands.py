"""synthesize and import: run the steps, then write everything or nothing."""

from pathlib import Path

from . import emit, friction, pipeline, progress, robustness
from .config import load_design
from .reading import read_text
from .errors import InputError
from .output import check_replaceable, write_directory


def synthesize(options):
    design, digest = load_design(options.design)
    if options.time_limit is not None:
        if not 0.001 <= options.time_limit <= 3600:
            raise InputError(f"--time-limit: value {options.time_limit:g}: must be at least 0.001 and at most 3600")
        design = design.model_copy(update={"synthesis": design.synthesis.model_copy(update={"time_limit_s": options.time_limit})})
    check_replaceable(options.out)
    progress.at("solves for the controller, reduces and rounds it")
    result = pipeline.synthesize(design, digest, Path(options.design).name)
    return _finish(result, options)


def import_controller(options):
    from .importer import load_controller

    design, _ = load_design(options.design)
    controller, digest = load_controller(options.controller, design)
    check_replaceable(options.out)
    progress.at("reduces and rounds the controller")
    result = pipeline.from_import(design, digest, Path(options.controller).name, controller)
    return _finish(result, options)


def texts_of(result, images):
    """Returns the text files by name, without the JSON."""
    from . import report

    name = result.design.name
    files = {f"{name}_controller.h": emit.header(result), f"{name}_controller.c": emit.source(result)}
    scenario = friction.scenario(result.design, result.plant, result.f32, result.source)
    if scenario is not None:
        files[f"{name}_scenario.yaml"] = scenario
    return {**files, "report.md": report.markdown(result, images), "report.html": report.html(result, images)}


def files_of(result, design_text, plots):
    """Every file of the output directory: name -> bytes."""
    images = {}
    if plots:
        progress.at("draws the plots")
        from . import plots as drawing

        images = drawing.draw_all(result)
    files = {name: text.encode() for name, text in texts_of(result, images).items()}
    files.update({f"{result.design.name}_design.json": emit.as_json(result).encode(), "DESIGN.yaml": design_text.encode()})
    files.update({f"plots/{n}.png": data for n, data in images.items()})
    return files


def _finish(result, options):
    progress.at("plays the loop with friction")
    played = friction.play(result.design, result.plant, result.f32, traces=not options.no_plots)
    result.traces = played.pop("traces", None)
    result.friction = played
    print(pipeline.table_text(result))
    for remark in result.warnings:
        print(f"note: {remark}")
    for sentence in robustness.in_words(result.robustness):
        print(f"note: {sentence}")
    print(friction.in_words(played))
    text, _ = read_text(options.design)
    files = files_of(result, text, not options.no_plots)
    write_directory(options.out, files)
    print(f"wrote {options.out}: {', '.join(sorted(files))}")
    return 0
