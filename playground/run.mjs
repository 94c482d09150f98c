// node run.mjs core.wasm SCENARIO.yaml...: runs each scenario and prints one line of JSON for it. joint=NUMBER,... runs a joint (joint.h).
import {readFileSync} from "node:fs";

import {makeCore} from "./core.mjs";

const [wasm, ...scenarios] = process.argv.slice(2);
const core = await makeCore(readFileSync(wasm));
for (const path of scenarios) {
    const run = path.startsWith("joint=") ? core.playJoint(path.slice(6).split(",").map(Number)) : core.play(readFileSync(path, "utf8"));
    console.log(JSON.stringify({path, digest: run.digest(), rms_error: run.rmsError, seconds: run.duration_ms / 1e3, ticks: run.columns.t_s.length}));
}
