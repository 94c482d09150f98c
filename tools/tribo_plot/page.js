// Draws the panels of #data with uPlot: those over time share their cursor and their zoom.
"use strict";

let pool; // a DataView of all numbers

async function unpack(text) {
    const packed = new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]);
    return new DataView(await new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
}

function numbers([code, offset, count]) {
    return Array.from({length: count}, (_, i) => (code === "d" ? pool.getFloat64(offset + 8 * i, true) : pool.getFloat32(offset + 4 * i, true)));
}

const known = (values) => values.map((value) => (Number.isNaN(value) ? null : value));
const timed = [];

function axes(panel) {
    const grid = {stroke: gridColour, width: 1};
    const values = (_, places) => places.map((place) => (place === null ? "" : String(Number(place.toPrecision(5)))));
    const names = panel.xNames && {splits: () => panel.xNames.map((_, i) => i), values: (_, places) => places.map((i) => panel.xNames[i] ?? "")};
    return [{label: panel.xLabel, labelSize: 22, size: 32, grid, values, ...names}, {label: panel.yLabel, labelSize: 18, size: 60, grid, values}];
}

// One table of x for all lines; a missing y is bridged, a gap is not.
function overTime(panel) {
    const tables = [];
    const series = [{label: "t (s)"}];
    const bands = [];
    for (const line of panel.lines) {
        const look = {stroke: line.colour, width: line.width, dash: line.dash, paths: line.step ? uPlot.paths.stepped({align: 1}) : undefined};
        tables.push([numbers(line.x), known(numbers(line.y))]);
        series.push({label: line.name, ...look, points: {show: false}, value: (_, y) => (y == null ? "–" : y.toPrecision(5))});
        if (line.band) {
            const [x, low, high] = line.band;
            const edge = {width: 0, points: {show: false}, value: (_, y) => (y == null ? "–" : y.toPrecision(5))};
            tables.push([numbers(x), numbers(high), numbers(low)]);
            series.push({label: "to", ...edge}, {label: "from", ...edge});
            bands.push({series: [series.length - 2, series.length - 1], fill: line.colour + "26"});
        }
    }
    const data = uPlot.join(tables);
    const [first, last] = [data[0][0], data[0][data[0].length - 1]];
    const whole = (u) => u.scales.x.min <= first && u.scales.x.max >= last;
    const options = {
        scales: {
            x: {time: false},
            y: {range: (u, low, high) => (panel.yRange && whole(u) ? panel.yRange : uPlot.rangeNum(low ?? 0, high ?? 1, 0.05, true))},
        },
        cursor: {sync: {key: "time"}, drag: {x: true, y: false}},
        series,
        bands,
        hooks: {setScale: [(u, key) => key === "x" && zoomTogether(u)]},
    };
    return {options, data};
}

let isZooming = false;

function zoomTogether(from) {
    if (isZooming) return;
    isZooming = true;
    const {min, max} = from.scales.x;
    for (const u of timed) {
        if (u !== from) u.setScale("x", {min, max});
    }
    isZooming = false;
}

function overOther(panel) {
    const data = [null];
    const series = [{}];
    for (const line of panel.lines) {
        data.push([known(numbers(line.x)), known(numbers(line.y))]);
        series.push({label: line.name, stroke: line.colour, colour: line.colour, thickness: line.width, dashes: line.dash, isPoints: line.points, paths: path, value: () => "",
                     facets: [{scale: "x", auto: true}, {scale: "y", auto: true}]});
    }
    const all = [0, 1].map((part) => ends(data.slice(1).flatMap((line) => line[part]), panel.isLog[part]));
    const range = (part) => (u, low, high) => (low === undefined || low === null ? all[part] : [low, high]);
    const options = {
        mode: 2,
        scales: {
            x: {time: false, auto: false, range: range(0), distr: panel.isLog[0] ? 3 : 1},
            y: {auto: false, range: range(1), distr: panel.isLog[1] ? 3 : 1},
        },
        cursor: {drag: {x: true, y: true}, points: {show: false}},
        series,
    };
    return {options, data, all};
}

function show(panel) {
    const cell = document.createElement("div");
    document.getElementById(panel.overTime ? "time" : "other").append(cell);
    const {options, data, all} = panel.overTime ? overTime(panel) : overOther(panel);
    const size = () => ({width: cell.clientWidth, height: panel.overTime ? 190 : 360});
    const whole = (u) => {
        u.setScale("x", {min: all[0][0], max: all[0][1]});
        u.setScale("y", {min: all[1][0], max: all[1][1]});
    };
    if (!panel.overTime) options.hooks = {ready: [whole]};
    const u = new uPlot({...size(), title: panel.title, axes: axes(panel), ...options}, data, cell);
    if (panel.overTime) timed.push(u);
    else u.over.addEventListener("dblclick", () => whole(u));
    addEventListener("resize", () => u.setSize(size()));
}

async function showAll() {
    const panels = JSON.parse(document.getElementById("data").textContent);
    pool = await unpack(document.getElementById("numbers").textContent);
    panels.forEach(show);
    document.body.dataset.drawn = panels.length; // for the tests
}

showAll();
