// The core in JavaScript, for a page, a worker or Node: makeCore(bytes of core.wasm) returns play(text of a scenario, q31) and playJoint(settings).

export async function makeCore(bytes) {
    const refuse = () => 8; // WASI's "bad file descriptor": a page has neither files nor arguments
    const clock = (_, __, at) => {
        new DataView(wasm.memory.buffer).setBigUint64(at, BigInt(Math.round(1e6 * performance.now())), true);
        return 0;
    };
    const system = new Proxy({clock_time_get: clock}, {get: (own, name) => own[name] ?? refuse});
    const wasm = (await WebAssembly.instantiate(bytes, {wasi_snapshot_preview1: system})).instance.exports;
    wasm._initialize();

    const read = (at) => {
        const all = new Uint8Array(wasm.memory.buffer);
        return new TextDecoder().decode(all.subarray(at, all.indexOf(0, at)));
    };
    const write = (text) => {
        const all = new TextEncoder().encode(text + "\0");
        const at = wasm.room(all.length);
        if (at === 0) throw new Error("out of memory");
        new Uint8Array(wasm.memory.buffer).set(all, at);
        return at;
    };

    // The columns are views that are valid until the next call.
    function played(run) {
        const start = performance.now();
        if (!run()) throw new Error(read(wasm.complaint()));
        const duration_ms = performance.now() - start;
        const columns = {};
        for (let i = 0; i < wasm.column_count(); i++) {
            columns[read(wasm.column_name(i))] = new Float64Array(wasm.memory.buffer, wasm.column(i), wasm.row_count());
        }
        return {
            columns,
            duration_ms,
            rmsError: wasm.rms_error(),
            maxError: wasm.max_error(),
            guard: read(wasm.guard()),
            digest: () => BigInt.asUintN(64, wasm.digest()).toString(16).padStart(16, "0"),
            scenario: () => read(wasm.scenario_text()),
        };
    }
    const play = (text, q31 = false) => played(() => wasm.play(write(text), q31));
    const playJoint = (settings) => played(() => {
        const at = wasm.room(8 * settings.length);
        if (at === 0) throw new Error("out of memory");
        new Float64Array(wasm.memory.buffer).set(settings, at / 8);
        return wasm.play_joint(at);
    });
    return {play, playJoint};
}
