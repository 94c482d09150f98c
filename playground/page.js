// The playground turns settings into a scenario, runs it twice in a worker (without and with compensation) and draws charts.
"use strict";

const RATIO_MODELS = ["coulomb", "karnopp", "armstrong", "bristle", "lugre", "elasto_plastic", "leuven", "maxwell_slip"];
const MODELS = {
    paper: "the paper's hysteresis", coulomb: "Coulomb", karnopp: "Karnopp", armstrong: "Armstrong", dahl: "Dahl", bristle: "bristles", lugre: "LuGre",
    elasto_plastic: "elasto-plastic", leuven: "Leuven", maxwell_slip: "Maxwell slip", reset_integrator: "reset integrator",
    bliman_sorine: "Bliman–Sorine", lubricated: "lubricated",
};

// A setting is [id, label, unit, least, most, step, default], or [id, label, choices] with the default first. A group belongs to one door, or to both (null).
const GROUPS = [
    [null, "What tribo works on", [
        ["door", "Machine", {axis: "arm with a force sensor", joint: "joint without one"}],
    ]],
    ["axis", "Friction of the arm", [
        ["offset", "Breakaway force without load", "N", 0.001, 0.05, 0.001, 0.007],
        ["slope", "Increase per newton of load", "N/N", 0, 0.6, 0.01, 0.3],
        ["mismatch", "Real friction, compared with your value", "%", -50, 100, 5, 0],
        ["sliding", "Sliding friction divided by breakaway", "", 0.5, 1, 0.01, 1],
        ["k", "Stiffness before breakaway", "", 4, 60, 1, 20],
        ["model", "Friction law", MODELS],
    ]],
    ["axis", "Compensation", [
        ["method", "Method", {feedforward: "tribo's feed-forward", paper: "the paper's, 2011"}],
        ["gain", "Gain of the paper's method", "", 0, 1.2, 0.05, 0.85],
    ]],
    ["axis", "Force sensor", [
        ["noise", "Noise, standard deviation", "mN", 0, 5, 0.1, 0],
        ["delay", "Delay", "ms", 0, 10, 0.5, 0],
    ]],
    ["axis", "Force to follow", [
        ["shape", "Shape", {triangle: "triangle", sine: "sine", sawtooth: "sawtooth", step: "step"}],
        ["low", "Lowest", "N", -1, 1, 0.05, 0.4],
        ["high", "Highest", "N", -1, 1, 0.05, 0.6],
        ["period", "Period", "s", 2, 40, 1, 20],
    ]],
    ["joint", "Friction of the joint", [
        ["slides", "Sliding friction", "N m", 0.02, 1, 0.02, 0.3],
        ["extra", "Extra friction at standstill", "%", 0, 100, 5, 20],
        ["guess", "Your guess, before tribo learns", "%", 0, 200, 10, 50],
        ["load", "Constant load, e.g. gravity", "N m", -1, 1, 0.05, 0],
    ]],
    ["joint", "Your position loop, a PD", [
        ["stiffness", "Stiffness", "N m/rad", 5, 100, 5, 20],
        ["counts", "Encoder counts per turn", {65536: "65,536", 16384: "16,384", 4096: "4,096"}],
    ]],
    ["joint", "Compensation", [
        ["part", "Fraction of friction to compensate", "", 0, 1, 0.01, 0.97],
    ]],
    ["joint", "Motion to follow", [
        ["motion", "Shape", {sine: "sine", triangle: "triangle", stops: "moves and stops"}],
        ["swing", "Swing to either side", "rad", 0.01, 1, 0.01, 0.25],
        ["time", "Period", "s", 0.5, 10, 0.5, 2],
    ]],
];
const SETTINGS = GROUPS.flatMap(([, , settings]) => settings);
const isChoice = (setting) => typeof setting[2] === "object";
const standard = (setting) => (isChoice(setting) ? words(setting)[0] : setting[6]);
// Keeps the order of the list: an object would sort its numbers.
const words = (setting) => (setting[0] === "counts" ? ["65536", "16384", "4096"] : Object.keys(setting[2]));
const standards = Object.fromEntries(SETTINGS.map((setting) => [setting[0], standard(setting)]));

const DURATION_S = 60;
const START_S = 20; // start of the metrics
const SHOWN_S = 1; // earlier values may lie outside a chart over time, because the arm starts at 0 N
const JOINT_EFFORT_MAX = 3; // N m, as in joint.c; the upper bound of friction before anything is learned
const POINTS = 900; // intervals of a line over time, two points each
const byId = (id) => document.getElementById(id);

// --- settings ---------------------------------------------------------------------------------------------------------------------

let values = {...standards};

// Reads the settings from the link. Ignores unknown settings and values outside their range.
function fromLink() {
    const given = new URLSearchParams(location.hash.slice(1));
    values = {...standards};
    for (const setting of SETTINGS) {
        const text = given.get(setting[0]);
        if (text === null) continue;
        if (isChoice(setting) ? words(setting).includes(text) : Number(text) >= setting[3] && Number(text) <= setting[4] && text.trim() !== "") {
            values[setting[0]] = isChoice(setting) ? text : Number(text);
        }
    }
}

function link() {
    const changed = Object.entries(values).filter(([id, value]) => value !== standards[id]);
    return changed.length ? "#" + new URLSearchParams(changed) : "";
}

// Rounds a number to 12 digits, to hide the errors of binary fractions.
const tidy = (number) => Number(number.toPrecision(12));

// Returns the scenario as nested objects, with compensation if `on`.
function scenarioOf(v, on) {
    const plant = 1 + v.mismatch / 100;
    const breakaway = {offset_N: v.offset, slope: v.slope};
    const k = {k_min: tidy(0.3 * v.k), k_max: v.k};
    const compensator = {method: on ? v.method : "off", friction: {breakaway, ...k}};
    if (on && v.method === "paper") compensator.gain = v.gain;
    const model = RATIO_MODELS.includes(v.model) ? {model: v.model, [v.model]: {sliding_ratio: v.sliding}} : {model: v.model};
    return {
        description: "from the playground",
        duration_s: DURATION_S,
        reference: {kind: v.shape, low_N: v.low, high_N: v.high, period_s: v.period},
        plant: {...model, friction: {breakaway: {offset_N: tidy(v.offset * plant), slope: tidy(v.slope * plant)}, ...k}},
        sensor: {noise_N: tidy(v.noise / 1000), delay_s: tidy(v.delay / 1000)},
        compensator,
        metrics: {start_s: START_S},
    };
}

// Returns the scenario as text: JSON is also YAML.
const textOf = (scenario) => JSON.stringify(scenario);

// Returns the numbers of joint.h's settings, with compensation if `on`.
function jointOf(v, on) {
    return [v.slides, v.extra / 100, v.load, tidy((v.slides * v.guess) / 100), v.stiffness, on ? v.part : 0, Number(v.counts),
            ["sine", "triangle", "stops"].indexOf(v.motion), v.swing, v.time];
}

// Returns the code that a user writes for this joint.
function configOf(v) {
    const travel = ((4 * 2 * Math.PI) / Number(v.counts)).toPrecision(3);
    return `tribo_joint_config_t config = tribo_joint_config();
config.sample_time_s = 0.001f;
config.effort_max    = ${JOINT_EFFORT_MAX}.0f; // N m
config.travel        = ${travel}f; // rad: four counts of the encoder
config.breakaway     = ${tidy((v.slides * v.guess) / 100)}f; // N m: a guess, which tribo corrects
config.gain          = ${v.part}f;
tribo_joint_f32_init(&joint, &config);
// every millisecond:
u = tribo_joint_f32_step(&joint, my_loop(q_ref, q), q_ref, q);
`;
}

function shown(setting, value) {
    const [, , unit, , , step] = setting;
    const places = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
    return `${value.toFixed(places)}${unit ? " " + unit : ""}`.replace("-", "−");
}

function showSettings() {
    for (const setting of SETTINGS) {
        const [id] = setting;
        byId(id).value = values[id];
        if (!isChoice(setting)) byId(`${id}-value`).textContent = shown(setting, values[id]);
    }
    const enable = (id, isOn) => {
        byId(id).disabled = !isOn;
        byId(id).closest(".row").classList.toggle("off", !isOn);
    };
    enable("gain", values.method === "paper");
    enable("sliding", RATIO_MODELS.includes(values.model));
    enable("period", values.shape !== "step");
    for (const group of document.querySelectorAll("fieldset[data-door]")) group.hidden = group.dataset.door !== values.door;
    const isJoint = values.door === "joint";
    byId("save").hidden = isJoint;
    byId("story").textContent = isJoint ? "This is a joint with stiction under a position loop, without tribo and with tribo between the loop and the drive. It has an encoder but no force sensor."
        : "This is a force loop on an arm with stiction, without and with compensation.";
    byId("export-title").textContent = isJoint ? "The joint's config in C" : "The scenario with compensation, as a file for tribo-sim run";
    for (const card of document.querySelectorAll(".what")) card.textContent = isJoint ? "RMS error of position" : "RMS error of force";
}

function makeForm() {
    const make = (name, properties = {}, ...children) => {
        const element = Object.assign(document.createElement(name), properties);
        element.append(...children);
        return element;
    };
    for (const [door, title, settings] of GROUPS) {
        const group = make("fieldset", {}, make("legend", {textContent: title}));
        if (door) group.dataset.door = door;
        for (const setting of settings) {
            const [id, label] = setting;
            const row = make("div", {className: "row"}, make("label", {htmlFor: id, textContent: label}));
            if (isChoice(setting)) {
                row.append(make("select", {id}, ...words(setting).map((word) => make("option", {value: word, textContent: setting[2][word]}))));
            } else {
                const [, , , min, max, step] = setting;
                row.append(make("output", {id: `${id}-value`}), make("input", {id, type: "range", min, max, step}));
            }
            row.addEventListener("input", () => {
                values[id] = isChoice(setting) ? byId(id).value : Number(byId(id).value);
                change();
            });
            group.append(row);
        }
        byId("settings").append(group);
    }
    const button = (text, action) => make("button", {type: "button", textContent: text, onclick: action});
    byId("settings").append(make("div", {className: "buttons"},
        button("Reset", () => {
            values = {...standards};
            change();
        }),
        button("Copy link", async (event) => {
            await navigator.clipboard.writeText(location.href);
            event.target.textContent = "Copied";
            setTimeout(() => (event.target.textContent = "Copy link"), 1500);
        }),
        Object.assign(button("Save scenario", () => {
            const file = make("a", {download: "playground.yaml", href: URL.createObjectURL(new Blob([byId("scenario").textContent]))});
            file.click();
        }), {id: "save"})));
    byId("settings").addEventListener("submit", (event) => event.preventDefault());
}

function change() {
    history.replaceState(null, "", link() || location.pathname + location.search);
    showSettings();
    play();
}

// --- runs, in a worker so that the sliders respond fast -------------------------------------------------------------------------------

// Runs in the worker: runs both scenarios and thins the columns for the charts.
async function work(makeCore, points) {
    // Keeps the smallest and the largest value of each part, in the order of time, so that no peak is lost.
    function thin(column, every, parts) {
        const kept = new Float32Array(2 * parts);
        for (let part = 0; part < parts; part++) {
            const end = Math.min((part + 1) * every, column.length);
            let low = part * every;
            let high = low;
            for (let i = low; i < end; i++) {
                if (column[i] < column[low]) low = i;
                if (column[i] > column[high]) high = i;
            }
            kept[2 * part] = column[Math.min(low, high)];
            kept[2 * part + 1] = column[Math.max(low, high)];
        }
        return kept;
    }
    function picture(run) {
        const c = run.columns;
        const every = Math.ceil(c.t_s.length / points);
        const parts = Math.ceil(c.t_s.length / every);
        const t = new Float32Array(2 * parts).map((_, i) => c.t_s[Math.min(Math.floor((i * every) / 2), c.t_s.length - 1)]);
        const over = {t};
        for (const [name, column] of Object.entries(c)) over[name] = thin(column, every, parts);
        const result = {over, rms: run.rmsError, guard: run.guard, duration_ms: run.duration_ms, simulated_s: Math.round(c.t_s.at(-1)), digest: run.digest()};
        if (c.q_ref) {
            over.error = thin(c.error.map((e) => 1e3 * e), every, parts);
            return result;
        }
        over.error = thin(c.r_N.map((r, i) => 1e3 * (r - c.F_N[i])), every, parts);
        const from = Math.floor(c.t_s.length / 3);
        const step = Math.max(1, Math.floor((c.t_s.length - from) / 20000));
        const curve = (column) => Float32Array.from({length: Math.floor((c.t_s.length - from) / step)}, (_, i) => column[from + i * step]);
        return {...result, n: curve(c.plant_n_N), left: curve(c.plant_n_N.map((n, i) => 1e3 * (n - c.f_N[i]))), scenario: run.scenario()};
    }
    let making;
    onmessage = async ({data}) => {
        if (data.wasm) {
            making = makeCore(data.wasm);
            return;
        }
        try {
            const core = await making;
            const play = (what) => (typeof what === "string" ? core.play(what) : core.playJoint(what));
            postMessage({id: data.id, door: data.door, pictures: data.runs.map((what) => picture(play(what)))});
        } catch (problem) {
            postMessage({id: data.id, complaint: problem.message});
        }
    };
}

const worker = new Worker(URL.createObjectURL(new Blob(
    [byId("core").textContent.replace("export ", ""), `(${work})(makeCore, ${POINTS});`], {type: "text/javascript"})));
let isBusy = true; // until the core is loaded
let isStale = true;
let runCount = 0;

async function start() {
    const packed = Uint8Array.from(atob(byId("wasm").textContent), (c) => c.charCodeAt(0));
    const wasm = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    worker.postMessage({wasm});
    isBusy = false;
    play();
}

// Runs the latest settings when the previous run is done.
function play() {
    isStale = true;
    if (isBusy) return;
    isStale = false;
    isBusy = true;
    const {door} = values;
    worker.postMessage({id: ++runCount, door, runs: [false, true].map((on) => (door === "joint" ? jointOf(values, on) : textOf(scenarioOf(values, on))))});
}

worker.onmessage = ({data}) => {
    isBusy = false;
    byId("complaint").textContent = data.complaint ?? "";
    if (data.pictures) show(data.door, data.pictures);
    document.body.dataset.run = data.id; // for the tests
    document.body.dataset.settled = !isStale;
    if (isStale) play();
};

const amount = (x, unit) => (x < 0.1 ? `${(1e3 * x).toPrecision(3)} m${unit}` : `${x.toPrecision(3)} ${unit}`);

function show(door, pictures) {
    const [without, compensated] = pictures;
    const unit = door === "joint" ? "rad" : "N";
    byId("without").textContent = amount(without.rms, unit);
    byId("with").textContent = amount(compensated.rms, unit);
    byId("gained").textContent = `${(without.rms / compensated.rms).toPrecision(3)} ×`;
    byId("duration").textContent = `${compensated.simulated_s} s in ${((without.duration_ms + compensated.duration_ms) / 2e3).toPrecision(2)} s`;
    const isFaded = !["", "none", "sound"].includes(compensated.guard);
    byId("long").textContent = isFaded ? `the guard has faded the compensation: ${compensated.guard}` : `errors count from ${door === "joint" ? 10 : START_S} s on`;
    byId("scenario").textContent = compensated.scenario ?? configOf(values);
    Object.assign(document.body.dataset, {digestWithout: without.digest, digestWith: compensated.digest, rmsWithout: without.rms, rmsWith: compensated.rms,
                                          seconds: Math.max(without.duration_ms, compensated.duration_ms) / 1e3});
    draw(door, pictures);
}

// --- charts -----------------------------------------------------------------------------------------------------------------------

const ticks = (_, places) => places.map((place) => (place === null ? "" : String(Number(place.toPrecision(5))).replace("-", "−")));
const axes = (x, y) => {
    const grid = {stroke: gridColour, width: 1};
    return [{label: x, labelSize: 20, size: 28, grid, values: ticks}, {label: y, labelSize: 18, size: 52, grid, values: ticks}];
};
const line = (signal, width = 1.2, more = {}) => ({
    label: signals[signal][0], stroke: signals[signal][1], width, points: {show: false},
    value: (_, y) => (y == null ? "–" : y.toPrecision(4).replace("-", "−")), ...more,
});
const stepped = {paths: uPlot.paths.stepped({align: 1}), value: (_, y) => (y == null ? "–" : String(Math.round(y % 1.4)))};
const curveOf = (signal) => ({
    label: signals[signal][0], stroke: signals[signal][1], colour: signals[signal][1], thickness: 1, dashes: [], paths: path, value: () => "",
    facets: [{scale: "x", auto: true}, {scale: "y", auto: true}],
});

const named = (label, stroke, width = 1.2, more = {}) => ({...line("error", width, more), label, stroke});
const compared = () => [named("without", withoutColour), named("with compensation", withColour, 1.8)];

// A chart is [title, unit, lines, height, function]. The function returns the columns of each panel: one panel for both runs, or one panel per run.
// On a telephone the first chart stands above the settings. A chart over net force (null) has curves.
const CHARTS = {
    axis: [
        ["Error r − F", "mN", compared(), 220, (both) => [both.map((o) => o.error)]],
        ["Force", "N", [line("y_N", 1), line("F_N", 1.4), line("r_N", 1, {dash: [5, 4]})], 200, (both) => both.map((o) => [o.y_N, o.F_N, o.r_N])],
        ["Relays", "", [line("Q", 1.2, stepped), line("Q2", 1.2, stepped), line("Q1", 1.2, stepped)], 150,
         (both) => both.map((o) => [o.plant_Q, o.plant_Q2.map((q) => q + 1.4), o.plant_Q1.map((q) => q + 2.8)])],
        ["Hysteresis", "net force less friction n − f (mN)", [curveOf("residual_N")], 300, null],
    ],
    joint: [
        ["Position error", "mrad", compared(), 220, (both) => [both.map((o) => o.error)]],
        ["Position", "rad", [...compared(), named("reference", "#000000", 1, {dash: [5, 4]})], 200, ([off, on]) => [[off.q, on.q, off.q_ref]]],
        ["Command u", "N m", compared(), 180, (both) => [both.map((o) => o.u)]],
        ["Learned friction", "N m", [named("learned", withColour, 1.8), named("at least", "#767676", 1, {dash: [5, 4]}), named("at most", "#767676", 1, {dash: [2, 3]})], 180,
         ([, on]) => [[on.friction, ...[on.low, on.high].map((column) => Array.from(column, (x, i) => (on.high[i] < JOINT_EFFORT_MAX ? x : null)))]]],
    ],
};
let drawn = []; // the panels of each chart
let drawnDoor = null;
let isZooming = false;

function zoomTogether(from) {
    if (isZooming) return;
    isZooming = true;
    const {min, max} = from.scales.x;
    for (const [chart, panels] of drawn.entries()) {
        for (const u of CHARTS[drawnDoor][chart][4] ? panels : []) if (u !== from) u.setScale("x", {min, max});
    }
    isZooming = false;
}

// The panels of a chart share one scale, so that they can be compared.
function common(sides) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of sides.flat(1)) {
        low = Math.min(low, ...ends(value, false));
        high = Math.max(high, ...ends(value, false));
    }
    return [low, high];
}

function dataOf(pick, pictures) {
    if (!pick) {
        const curves = pictures.map(({n, left}) => [n, left].map((column) => Array.from(column)));
        return {data: curves.map((curve) => [null, curve]), ranges: [0, 1].map((part) => common(curves.map((curve) => [curve[part]])))};
    }
    const t = Array.from(pictures[0].over.t);
    const panels = pick(pictures.map(({over}) => over)).map((list) => list.map((column) => Array.from(column)));
    const first = t.findIndex((at) => at >= SHOWN_S);
    return {data: panels.map((list) => [t, ...list]), ranges: [[0, pictures[0].simulated_s], common(panels.map((list) => list.map((column) => column.slice(first))))]};
}

function makePanel([title, unit, series, height, pick], panel, isAlone, place, box, data) {
    const cell = Object.assign(document.createElement("div"), {className: isAlone ? "chart wide" : "chart"});
    place.append(cell);
    const size = () => ({width: cell.clientWidth - 12, height});
    const options = pick
        ? {scales: {x: {time: false}, y: {range: () => box.ranges[1]}}, cursor: {sync: {key: "time"}, drag: {x: true, y: false}},
           hooks: {setScale: [(from, key) => key === "x" && zoomTogether(from)]}, series: [{label: "t (s)"}, ...series]}
        : {mode: 2, scales: {x: {time: false, auto: false, range: (_, low, high) => (low == null ? box.ranges[0] : [low, high])},
                             y: {auto: false, range: (_, low, high) => (low == null ? box.ranges[1] : [low, high])}},
           cursor: {drag: {x: true, y: true}, points: {show: false}}, series: [{}, ...series]};
    const relays = unit === "" ? {values: (_, places) => places.map((y) => ["Q", "Q2", "Q1"][Math.round((y - 0.5) / 1.4)]),
                                  splits: () => [0.5, 1.9, 3.3], grid: {show: false}} : {};
    const [x, y] = axes(pick ? "time (s)" : "net force n (N)", unit === "" ? " " : unit);
    const u = new uPlot({...size(), title: isAlone ? title : `${title}, ${["without", "with"][panel]} compensation`, axes: [x, {...y, ...relays}], ...options}, data, cell);
    u.box = box;
    new ResizeObserver(() => u.setSize(size())).observe(cell);
    if (!pick) u.over.addEventListener("dblclick", () => whole(u));
    return u;
}

function draw(door, pictures) {
    if (door !== drawnDoor) {
        drawn.flat().forEach((u) => u.destroy());
        drawn = [];
        byId("first").replaceChildren();
        byId("charts").replaceChildren();
        drawnDoor = door;
    }
    CHARTS[door].forEach((chart, number) => {
        const pick = chart[4];
        const {data, ranges} = dataOf(pick, pictures);
        if (!drawn[number]) {
            const box = {ranges}; // shared by all panels of this chart
            drawn[number] = data.map((one, panel) => makePanel(chart, panel, data.length === 1, byId(number === 0 ? "first" : "charts"), box, one));
        }
        const view = drawn[number][0].scales.x;
        const isZoomed = pick && view.min != null && (view.min > 0 || view.max < pictures[0].simulated_s - 1);
        const {min, max} = view;
        isZooming = true;
        drawn[number].forEach((u, panel) => {
            u.box.ranges = ranges;
            u.setData(data[panel], !isZoomed);
            if (isZoomed) u.setScale("x", {min, max});
            else if (!pick) whole(u);
        });
        isZooming = false;
    });
}

function whole(u) {
    const [x, y] = u.box.ranges;
    u.setScale("x", {min: x[0], max: x[1]});
    u.setScale("y", {min: y[0], max: y[1]});
}

addEventListener("hashchange", () => {
    fromLink();
    showSettings();
    play();
});
makeForm();
fromLink();
showSettings();
start();
