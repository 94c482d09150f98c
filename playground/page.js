// The playground: settings -> scenario -> two runs in a worker -> charts.
"use strict";

const RATIO_MODELS = ["coulomb", "karnopp", "armstrong", "bristle", "lugre", "elasto_plastic", "leuven", "maxwell_slip"];
const MODELS = ["paper", "dahl", "reset_integrator", "bliman_sorine", "lubricated", ...RATIO_MODELS];

// A setting: id, label, unit, least, most, step, default; or words to choose from, the first the default.
const GROUPS = [
    ["Friction", [
        ["offset", "Breakaway at no force", "N", 0.001, 0.05, 0.001, 0.007],
        ["slope", "and over |F|", "N/N", 0, 0.6, 0.01, 0.3],
        ["k", "k inside stiction, slow (fast: 0.3 of it)", "", 4, 60, 1, 20],
        ["model", "Plant's friction", ["paper", ...MODELS.slice(1)]],
        ["sliding", "Sliding over breakaway", "", 0.5, 1, 0.01, 1],
        ["mismatch", "Plant's breakaway, against the believed", "%", -50, 100, 5, 0],
    ]],
    ["Compensation", [
        ["method", "Method", ["feedforward", "paper"]],
        ["gain", "Gain of the paper's method", "", 0, 1.2, 0.05, 0.85],
    ]],
    ["Sensor", [
        ["noise", "Noise, standard deviation", "mN", 0, 5, 0.1, 0],
        ["delay", "Delay", "ms", 0, 10, 0.5, 0],
    ]],
    ["Reference", [
        ["shape", "Shape", ["triangle", "sine", "sawtooth", "step"]],
        ["low", "Low", "N", -1, 1, 0.05, 0.4],
        ["high", "High", "N", -1, 1, 0.05, 0.6],
        ["period", "Period", "s", 2, 40, 1, 20],
    ]],
];
const SETTINGS = GROUPS.flatMap(([, settings]) => settings);
const isChoice = (setting) => Array.isArray(setting[2]);
const standard = (setting) => (isChoice(setting) ? setting[2][0] : setting[6]);
const standards = Object.fromEntries(SETTINGS.map((setting) => [setting[0], standard(setting)]));

const DURATION_S = 60;
const START_S = 20; // of the metrics
const SHOWN_S = 1; // what is before may lie outside a chart over time: the arm starts at 0 N
const POINTS = 900; // of a line over time, two each
const byId = (id) => document.getElementById(id);

// --- settings ---------------------------------------------------------------------------------------------------------------------

let values = {...standards};

// From the link; what is no setting or outside its range is left out.
function fromLink() {
    const given = new URLSearchParams(location.hash.slice(1));
    values = {...standards};
    for (const setting of SETTINGS) {
        const text = given.get(setting[0]);
        if (text === null) continue;
        if (isChoice(setting) ? setting[2].includes(text) : Number(text) >= setting[3] && Number(text) <= setting[4] && text.trim() !== "") {
            values[setting[0]] = isChoice(setting) ? text : Number(text);
        }
    }
}

function link() {
    const changed = Object.entries(values).filter(([id, value]) => value !== standards[id]);
    return changed.length ? "#" + new URLSearchParams(changed) : "";
}

// A number without the dust of binary fractions.
const tidy = (number) => Number(number.toPrecision(12));

// The scenario as nested objects; `on` is with compensation.
function scenarioOf(v, on) {
    const plant = 1 + v.mismatch / 100;
    const breakaway = {offset_N: v.offset, slope: v.slope};
    const k = {k_min: tidy(0.3 * v.k), k_max: v.k};
    const believed = {method: on ? v.method : "off", friction: {breakaway, ...k}};
    if (on && v.method === "paper") believed.gain = v.gain;
    const model = RATIO_MODELS.includes(v.model) ? {model: v.model, [v.model]: {sliding_ratio: v.sliding}} : {model: v.model};
    return {
        description: "from the playground",
        duration_s: DURATION_S,
        reference: {kind: v.shape, low_N: v.low, high_N: v.high, period_s: v.period},
        plant: {...model, friction: {breakaway: {offset_N: tidy(v.offset * plant), slope: tidy(v.slope * plant)}, ...k}},
        sensor: {noise_N: tidy(v.noise / 1000), delay_s: tidy(v.delay / 1000)},
        compensator: believed,
        metrics: {start_s: START_S},
    };
}

// YAML, of which JSON is a part.
const textOf = (scenario) => JSON.stringify(scenario);

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
}

function makeForm() {
    const make = (name, properties = {}, ...children) => {
        const element = Object.assign(document.createElement(name), properties);
        element.append(...children);
        return element;
    };
    for (const [title, settings] of GROUPS) {
        const group = make("fieldset", {}, make("legend", {textContent: title}));
        for (const setting of settings) {
            const [id, label] = setting;
            const row = make("div", {className: "row"}, make("label", {htmlFor: id, textContent: label}));
            if (isChoice(setting)) {
                row.append(make("select", {id}, ...setting[2].map((word) => make("option", {value: word, textContent: word.replace("_", " ")}))));
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
        button("Save scenario", () => {
            const file = make("a", {download: "playground.yaml", href: URL.createObjectURL(new Blob([byId("scenario").textContent]))});
            file.click();
        })));
    byId("settings").addEventListener("submit", (event) => event.preventDefault());
}

function change() {
    history.replaceState(null, "", link() || location.pathname + location.search);
    showSettings();
    play();
}

// --- runs, in a worker so that the sliders stay quick -------------------------------------------------------------------------------

// In the worker: plays both scenarios and thins what is drawn.
async function work(makeCore, points) {
    // Of each part its first, least or largest value, in the order of time: no peak is lost.
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
        const error = c.r_N.map((r, i) => 1e3 * (r - c.F_N[i]));
        const over = {t, error: thin(error, every, parts)};
        for (const name of ["r_N", "F_N", "y_N", "plant_Q1", "plant_Q2", "plant_Q"]) over[name] = thin(c[name], every, parts);
        const from = Math.floor(c.t_s.length / 3);
        const step = Math.max(1, Math.floor((c.t_s.length - from) / 20000));
        const curve = (column) => Float32Array.from({length: Math.floor((c.t_s.length - from) / step)}, (_, i) => column[from + i * step]);
        return {over, n: curve(c.plant_n_N), left: curve(c.plant_n_N.map((n, i) => 1e3 * (n - c.f_N[i]))), rms_N: run.rmsError_N, guard: run.guard, duration_ms: run.duration_ms,
                digest: run.digest(), scenario: run.scenario()};
    }
    let making;
    onmessage = async ({data}) => {
        if (data.wasm) {
            making = makeCore(data.wasm);
            return;
        }
        try {
            const core = await making;
            postMessage({id: data.id, pictures: data.texts.map((text) => picture(core.play(text)))});
        } catch (problem) {
            postMessage({id: data.id, complaint: problem.message});
        }
    };
}

const worker = new Worker(URL.createObjectURL(new Blob(
    [byId("core").textContent.replace("export ", ""), `(${work})(makeCore, ${POINTS});`], {type: "text/javascript"})));
let isBusy = true; // until the core is there
let isStale = true;
let runCount = 0;

async function start() {
    const packed = Uint8Array.from(atob(byId("wasm").textContent), (c) => c.charCodeAt(0));
    const wasm = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    worker.postMessage({wasm});
    isBusy = false;
    play();
}

// The latest settings, once the run before is done.
function play() {
    isStale = true;
    if (isBusy) return;
    isStale = false;
    isBusy = true;
    worker.postMessage({id: ++runCount, texts: [false, true].map((on) => textOf(scenarioOf(values, on)))});
}

worker.onmessage = ({data}) => {
    isBusy = false;
    byId("complaint").textContent = data.complaint ?? "";
    if (data.pictures) show(data.pictures);
    document.body.dataset.run = data.id; // for the tests
    document.body.dataset.settled = !isStale;
    if (isStale) play();
};

const newtons = (n) => (n < 0.1 ? `${(1e3 * n).toPrecision(3)} mN` : `${n.toPrecision(3)} N`);

function show(pictures) {
    const [without, compensated] = pictures;
    byId("without").textContent = newtons(without.rms_N);
    byId("with").textContent = newtons(compensated.rms_N);
    byId("gained").textContent = `${(without.rms_N / compensated.rms_N).toPrecision(3)} ×`;
    byId("duration").textContent = `${DURATION_S} s in ${((without.duration_ms + compensated.duration_ms) / 2e3).toPrecision(2)} s`;
    byId("long").textContent = compensated.guard !== "none" && compensated.guard !== "" ? `the guard has faded it: ${compensated.guard}` : `errors count from ${START_S} s on`;
    byId("scenario").textContent = compensated.scenario;
    Object.assign(document.body.dataset, {digestWithout: without.digest, digestWith: compensated.digest, rmsWith: compensated.rms_N,
                                          seconds: Math.max(without.duration_ms, compensated.duration_ms) / 1e3});
    draw(pictures);
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

// Title, axes, lines, data of a picture, height; the one over net force is a curve.
const CHARTS = [
    ["Force", "N", [line("y_N", 1), line("F_N", 1.4), line("r_N", 1, {dash: [5, 4]})], (o) => [o.y_N, o.F_N, o.r_N], 200],
    ["Error r − F", "mN", [line("error", 1.1)], (o) => [o.error], 180],
    ["Relays", "", [line("Q", 1.2, stepped), line("Q2", 1.2, stepped), line("Q1", 1.2, stepped)],
     (o) => [o.plant_Q, o.plant_Q2.map((q) => q + 1.4), o.plant_Q1.map((q) => q + 2.8)], 150],
    ["Hysteresis: net force less friction", "n − f (mN)", [curveOf("residual_N")], null, 300],
];
const drawn = []; // of each chart both sides
let isZooming = false;

function zoomTogether(from) {
    if (isZooming) return;
    isZooming = true;
    const {min, max} = from.scales.x;
    for (const [chart] of drawn.entries()) {
        for (const u of CHARTS[chart][3] ? drawn[chart] : []) if (u !== from) u.setScale("x", {min, max});
    }
    isZooming = false;
}

// Both sides have one scale, so that they can be compared.
function common(sides) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of sides.flat(1)) {
        low = Math.min(low, ...ends(value, false));
        high = Math.max(high, ...ends(value, false));
    }
    return [low, high];
}

function dataOf(chart, pictures) {
    const pick = CHARTS[chart][3];
    if (!pick) {
        const curves = pictures.map(({n, left}) => [n, left].map((column) => Array.from(column)));
        return {data: curves.map((curve) => [null, curve]), ranges: [0, 1].map((part) => common(curves.map((curve) => [curve[part]])))};
    }
    const lists = pictures.map(({over}) => pick(over).map((column) => Array.from(column)));
    const first = pictures[0].over.t.findIndex((t) => t >= SHOWN_S);
    return {data: lists.map((list, side) => [Array.from(pictures[side].over.t), ...list]),
            ranges: [[0, DURATION_S], common(lists.map((list) => list.map((column) => column.slice(first))))]};
}

function draw(pictures) {
    CHARTS.forEach(([title, unit, series, pick, height], chart) => {
        const {data, ranges} = dataOf(chart, pictures);
        if (!drawn[chart]) {
            drawn[chart] = data.map((_, side) => {
                const box = {ranges}; // of this chart, for both sides
                const cell = Object.assign(document.createElement("div"), {className: "chart"});
                byId("charts").append(cell);
                const size = () => ({width: cell.clientWidth - 12, height});
                const options = pick
                    ? {scales: {x: {time: false}, y: {range: () => box.ranges[1]}}, cursor: {sync: {key: "time"}, drag: {x: true, y: false}},
                       hooks: {setScale: [(from, key) => key === "x" && zoomTogether(from)]}, series: [{label: "t (s)"}, ...series]}
                    : {mode: 2, scales: {x: {time: false, auto: false, range: (_, low, high) => (low == null ? box.ranges[0] : [low, high])},
                                         y: {auto: false, range: (_, low, high) => (low == null ? box.ranges[1] : [low, high])}},
                       cursor: {drag: {x: true, y: true}, points: {show: false}}, series: [{}, ...series]};
                const words = unit === "" ? {values: (_, places) => places.map((y) => ["Q", "Q2", "Q1"][Math.round((y - 0.5) / 1.4)]),
                                             splits: () => [0.5, 1.9, 3.3], grid: {show: false}} : {};
                const [x, y] = axes(pick ? "time (s)" : "net force n (N)", unit === "" ? " " : unit);
                const u = new uPlot({...size(), title: `${title}${["", ", with compensation"][side]}`, axes: [x, {...y, ...words}], ...options}, data[side], cell);
                u.box = box;
                new ResizeObserver(() => u.setSize(size())).observe(cell);
                if (!pick) u.over.addEventListener("dblclick", () => whole(u));
                return u;
            });
        }
        const view = drawn[chart][0].scales.x;
        const isZoomed = pick && view.min != null && (view.min > 0 || view.max < DURATION_S - 1);
        const {min, max} = view;
        isZooming = true;
        drawn[chart].forEach((u, side) => {
            u.box.ranges = ranges;
            u.setData(data[side], !isZoomed);
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
