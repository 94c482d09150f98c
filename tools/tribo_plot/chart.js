// What uPlot has not, for every page: curves over another signal than time.
"use strict";

// A line through points in the order of time, over another signal.
function path(u, index) {
    uPlot.orient(u, index, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height, moveTo, lineTo) => {
        const drawn = new Path2D();
        const [x, y] = u.data[index];
        let isDown = false;
        for (let i = 0; i < x.length; i++) {
            if (x[i] === null || y[i] === null) {
                isDown = false;
                continue;
            }
            const [atX, atY] = [toX(x[i], scaleX, width, left), toY(y[i], scaleY, height, top)];
            if (series.isPoints) drawn.rect(atX - 1.5, atY - 1.5, 3, 3);
            else (isDown ? lineTo : moveTo)(drawn, atX, atY);
            isDown = true;
        }
        u.ctx.save();
        u.ctx.beginPath();
        u.ctx.rect(left, top, width, height);
        u.ctx.clip();
        u.ctx.strokeStyle = series.colour;
        u.ctx.lineWidth = series.thickness * devicePixelRatio;
        u.ctx.setLineDash(series.dashes.map((part) => part * devicePixelRatio));
        u.ctx.fillStyle = series.colour;
        if (series.isPoints) u.ctx.fill(drawn);
        else u.ctx.stroke(drawn);
        u.ctx.restore();
    });
    return null;
}

function ends(values, isLog) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of values) {
        if (value === null) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
    }
    if (isLog) return [low / 1.2, high * 1.2];
    const room = 0.05 * (high - low || 1);
    return [low - room, high + room];
}
