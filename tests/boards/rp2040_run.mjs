// An RP2040 of rp2040js with an image, stepped from outside: a request a line on standard input, an answer a line on standard output, both
// JSON. No boot ROM is run: what it does, copying the second stage into RAM, checking its CRC and calling it, is done here.
//
//     {"step": us, "adc": [codes], "pins": {pin: level}, "send": [bytes]}
//         -> {"us", "duty": [high shares of the two PWM pins], "enable", "drives", "log": [bytes], "reset": reason, "baud"}

import fs from "node:fs";
import path from "node:path";

const [modules, image, scratch] = process.argv.slice(2);
const { RP2040, ConsoleLogger, LogLevel } = await import(path.resolve(modules, "dist/esm/index.js"));

const FLASH = 0x10000000, STAGE_IN_RAM = 0x20041f00, STAGE = 256;
const FORWARD = 2, BACKWARD = 3, ENABLE = 4, DRIVES = 7;

const chip = new RP2040();
chip.logger = new ConsoleLogger(LogLevel.Error, true);
const core = chip.core;

// The image, from its UF2.
const blocks = fs.readFileSync(image);
for (let at = 0; at < blocks.length; at += 512) {
    const address = blocks.readUInt32LE(at + 12), size = blocks.readUInt32LE(at + 16);
    chip.flash.set(blocks.subarray(at + 32, at + 32 + size), address - FLASH);
}

// The boot ROM's part.
let crc = 0xffffffff;
for (const byte of chip.flash.subarray(0, STAGE - 4)) {
    crc = (crc ^ (byte << 24)) >>> 0;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 31 ? (crc << 1) ^ 0x04c11db7 : crc << 1) >>> 0;
}
if (crc !== chip.flashView.getUint32(STAGE - 4, true)) {
    console.log(JSON.stringify({ error: "the second stage's CRC is wrong: the boot ROM would not start it" }));
    process.exit(1);
}
chip.sram.fill(0xa5);
for (let i = 0; i < STAGE; i++) chip.writeUint8(STAGE_IN_RAM + i, chip.flash[i]);
core.SP = 0x20042000;
core.PC = STAGE_IN_RAM;
const words = scratch ? JSON.parse(scratch) : null; // of a chip that has run before
const watchdog = chip.peripherals[0x40058];
if (words) {
    watchdog.scratchData.set(words.scratch);
    watchdog.reason = words.reason;
}

// What is seen from outside.
let log = [], high = [0, 0], since = [null, null], reset = null;
chip.uart[0].onByte = (byte) => log.push(byte);
watchdog.onWatchdogTrigger = () => {
    watchdog.alarm.enable = false; // the emulator would call this again and again at the same instant
    reset = { reason: watchdog.reason, scratch: [...watchdog.scratchData] };
};
const isHigh = (pin) => { const gpio = chip.gpio[pin]; return gpio.outputEnable && gpio.outputValue; };
[FORWARD, BACKWARD].forEach((pin, i) => chip.gpio[pin].addListener(() => {
    const now = chip.clock.nanos;
    if (isHigh(pin) && since[i] === null) since[i] = now;
    if (!isHigh(pin) && since[i] !== null) { high[i] += now - since[i]; since[i] = null; }
}));

/// An enable that is read back: the pad's input follows its output.
const followEnable = () => chip.gpio[ENABLE].setInputValue(shorted === null ? isHigh(ENABLE) : shorted);
let shorted = null;
chip.gpio[ENABLE].addListener(followEnable);
chip.gpio[1].setInputValue(true);

/// Without its FIFO a UART holds one byte, and loses the next ones until that is read.
function feed(byte) {
    if (chip.uart[0].fifosEnabled || chip.uart[0].rxFIFO.empty) chip.uart[0].feedByte(byte);
}

function run(us) {
    const until = chip.clock.nanos + us * 1000;
    while (chip.clock.nanos < until && !reset) {
        if (core.waiting) {
            const wait = chip.clock.nanosToNextAlarm;
            chip.clock.tick(Math.max(1, Math.min(wait || Infinity, until - chip.clock.nanos)));
        } else {
            chip.clock.tick(core.executeInstruction() * 1e9 / chip.clkSys);
        }
    }
}

function answer(request) {
    (request.adc || []).forEach((code, channel) => { chip.adc.channelValues[channel] = code; });
    for (const [pin, level] of Object.entries(request.pins || {})) chip.gpio[pin].setInputValue(level);
    if ("shorted" in request) { shorted = request.shorted; followEnable(); }
    if (request.dead_adc !== undefined) chip.adc.onADCRead = () => {};
    if (request.no_ticks) core.enabledInterrupts &= ~1;
    if (request.interrupt !== undefined) { core.enabledInterrupts |= 1 << request.interrupt; chip.setInterrupt(request.interrupt, true); }
    for (const byte of request.send || []) { feed(byte); run(87); }
    const begin = chip.clock.nanos;
    high = [0, 0];
    since = since.map((at) => (at === null ? null : begin));
    run(request.step || 0);
    const now = chip.clock.nanos, span = Math.max(1, now - begin);
    const duty = high.map((time, i) => (time + (since[i] === null ? 0 : now - since[i])) / span);
    const result = { us: now / 1000, duty, enable: isHigh(ENABLE), drives: isHigh(DRIVES), log, reset, baud: chip.uart[0].baudRate,
                     hz: chip.clkSys };
    log = [];
    return result;
}

// Synchronous: a line at a time.
let rest = "";
const buffer = Buffer.alloc(65536);
for (;;) {
    let end;
    while ((end = rest.indexOf("\n")) < 0) {
        const count = fs.readSync(0, buffer);
        if (count === 0) process.exit(0);
        rest += buffer.toString("latin1", 0, count);
    }
    const line = rest.slice(0, end);
    rest = rest.slice(end + 1);
    fs.writeSync(1, JSON.stringify(answer(JSON.parse(line))) + "\n");
}
