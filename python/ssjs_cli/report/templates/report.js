"use strict";
(function () {
  const { report, byId, drawn, draw, drawAll, connectLayers, tameWheel, connectTables, connectPrint } = ssjsPage;

  /** From drawn metres to pixels of the map's frame, as plotly shows it at this instant. */
  function viewOf(map) {
    const across = map._fullLayout.xaxis, up = map._fullLayout.yaxis;
    const scaleX = across._length / (across.range[1] - across.range[0]), scaleY = up._length / (up.range[1] - up.range[0]);
    return {
      left: across._offset, top: up._offset, width: across._length, height: up._length, scaleX, scaleY,
      x: (value) => across._offset + (value - across.range[0]) * scaleX,
      y: (value) => up._offset + up._length - (value - up.range[0]) * scaleY,
    };
  }

  /** Degrees above and to the right of a map whose mission has a place on earth: at any zoom those of the metres opposite. */
  function keepDegreesInStep(map) {
    const degrees = map.layout.meta && map.layout.meta.degrees;
    if (!degrees) return;
    const moved = {};
    for (const name of ["xaxis", "yaxis"]) {
      const [zero, scale] = degrees[name], metres = map._fullLayout[name].range, shown = map._fullLayout[name + "2"].range;
      const wanted = metres.map((end) => zero + scale * end), span = Math.abs(wanted[1] - wanted[0]);
      if (wanted.some((end, i) => Math.abs(end - shown[i]) > 1e-6 * span)) moved[name + "2.range"] = wanted;
    }
    if (Object.keys(moved).length) Plotly.relayout(map, moved);
  }

  /** The marks above the plot lie on a sheet as large as it. */
  function fitMarks(map) {
    const marks = byId("replay-marks"), width = map._fullLayout.width, height = map._fullLayout.height;
    marks.setAttribute("width", width);
    marks.setAttribute("height", height);
    marks.setAttribute("viewBox", `0 0 ${width} ${height}`);
    placeFocus();
  }

  let placeFocus = () => {};
  const placeFocusNow = () => placeFocus();
  function showOnMap(x, y) {
    const map = byId("map"), mark = byId("focus-mark");
    if (!drawn.map) return;
    const axis = map._fullLayout.xaxis, other = map._fullLayout.yaxis;
    const first = report.figures.map.layout;
    const half = 0.09 * Math.max(first.xaxis.range[1] - first.xaxis.range[0], first.yaxis.range[1] - first.yaxis.range[0]);
    const halfAcross = half * Math.max(1, axis._length / other._length);
    const halfUp = half * Math.max(1, other._length / axis._length);
    Plotly.relayout(map, { "xaxis.range": [x - halfAcross, x + halfAcross], "yaxis.range": [y - halfUp, y + halfUp] });
    placeFocus = () => {
      const v = viewOf(map);
      mark.setAttribute("cx", v.x(x).toFixed(2));
      mark.setAttribute("cy", v.y(y).toFixed(2));
    };
    mark.classList.remove("shown");
    mark.getBoundingClientRect(); // lets the animation begin anew
    mark.classList.add("shown");
    placeFocus();
    byId("map-section").scrollIntoView();
  }

  // ---- replay -----------------------------------------------------------------------------------------------------
  const CHI2_95_TWO_DOF = 5.991464547107979;
  const PLAY_ICON = "M4 2 L14 8 L4 14 Z", PAUSE_ICON = "M3 2 H6.5 V14 H3 Z M9.5 2 H13 V14 H9.5 Z";

  function countUpTo(times, time) {
    let low = 0, high = times.length;
    while (low < high) { const middle = (low + high) >> 1; if (times[middle] <= time) low = middle + 1; else high = middle; }
    return low;
  }

  function createReplay(replay) {
    const map = byId("map"), frame = byId("map-frame"), canvas = byId("replay-canvas");
    const vehicle = byId("vehicle-marker"), ellipse = byId("vehicle-ellipse"), slider = byId("replay-slider");
    const readout = byId("replay-readout"), icon = byId("replay-icon"), button = byId("replay-play");
    const choice = byId("replay-estimate"), duration = byId("replay-duration");
    const context = canvas.getContext("2d");
    const last = replay.time_s.length - 1;
    let moment = last, playing = false, previous = 0, exact = last, active = false;
    slider.value = String(last);

    const estimate = () => replay.estimates[choice.selectedIndex] || replay.estimates[0];

    /** What the canvas shows already: forward steps add to it, anything else begins anew. */
    let painted = { moment: -1, scene: "" };

    function paintPast(v) {
      const ratio = window.devicePixelRatio || 1, width = map.clientWidth, height = map.clientHeight;
      const across = map._fullLayout.xaxis.range, up = map._fullLayout.yaxis.range;
      const scene = active ? [estimate().key, ratio, width, height, ...across, ...up].join() : "";
      if (scene === painted.scene && moment === painted.moment) return;
      const resized = canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio);
      if (resized) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        canvas.style.width = width + "px";
        canvas.style.height = height + "px";
      }
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      if (resized || scene !== painted.scene || moment < painted.moment) {
        context.clearRect(0, 0, width, height);
        painted = { moment: -1, scene };
      }
      if (active) addPast(v, painted.moment, moment);
      painted.moment = moment;
    }

    /** Draws what came after the moment `from` (-1: everything) up to the moment `to`. */
    function addPast(v, from, to) {
      const shown = estimate(), now = replay.time_s[to];
      const span = (times) => [from < 0 ? 0 : countUpTo(times, replay.time_s[from]), countUpTo(times, now)];
      context.save();
      context.beginPath(); context.rect(v.left, v.top, v.width, v.height); context.clip();
      if (replay.landmarks) {
        const [first, end] = span(replay.landmarks.time_s);
        for (let i = first; i < end; ++i) {
          context.fillStyle = replay.palette[replay.landmarks.colour[i]];
          context.beginPath(); context.arc(v.x(replay.landmarks.x[i]), v.y(replay.landmarks.y[i]), 2.5, 0, 2 * Math.PI); context.fill();
        }
      }
      if (replay.loops) {
        const [first, end] = span(replay.loops.time_s);
        context.strokeStyle = "#b5179e"; context.lineWidth = 1.3; context.beginPath();
        for (let i = first; i < end; ++i) {
          const ends = replay.loops.ends[i];
          context.moveTo(v.x(ends[0]), v.y(ends[1])); context.lineTo(v.x(ends[2]), v.y(ends[3]));
        }
        context.stroke();
      }
      const begin = Math.max(from, 0);
      context.strokeStyle = shown.key === "online" ? "#e4572e" : "#14213d"; context.lineWidth = 1.9;
      context.lineJoin = context.lineCap = "round";
      context.beginPath(); context.moveTo(v.x(shown.x[begin]), v.y(shown.y[begin]));
      for (let i = begin + 1; i <= to; ++i) context.lineTo(v.x(shown.x[i]), v.y(shown.y[i]));
      context.stroke();
      if (replay.bases) {
        const [first, end] = span(replay.bases.time_s);
        context.lineWidth = 1; context.strokeStyle = "#14213d";
        for (let i = first; i < end; ++i) {
          context.fillStyle = replay.palette[replay.bases.colour[i]];
          context.beginPath(); context.rect(v.x(replay.bases.x[i]) - 2.5, v.y(replay.bases.y[i]) - 2.5, 5, 5); context.fill(); context.stroke();
        }
      }
      context.restore();
    }

    function drawVehicle(v) {
      const shown = estimate(), x = v.x(shown.x[moment]), y = v.y(shown.y[moment]);
      const inside = x >= v.left && x <= v.left + v.width && y >= v.top && y <= v.top + v.height;
      vehicle.style.display = ellipse.style.display = inside ? "" : "none";
      vehicle.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)}) rotate(${(-shown.heading[moment] * 180 / Math.PI).toFixed(2)})`);
      if (!shown.covariance) { ellipse.removeAttribute("d"); return; }
      const xx = shown.covariance[0][moment], xy = shown.covariance[1][moment], yy = shown.covariance[2][moment];
      if (xx === null || xy === null || yy === null) { ellipse.removeAttribute("d"); return; }
      const centre = 0.5 * (xx + yy), radius = Math.hypot(0.5 * (xx - yy), xy), turn = 0.5 * Math.atan2(2 * xy, xx - yy);
      const major = Math.sqrt(CHI2_95_TWO_DOF * Math.max(centre + radius, 0)), minor = Math.sqrt(CHI2_95_TWO_DOF * Math.max(centre - radius, 0));
      const rx = (major * v.scaleX).toFixed(2), ry = (minor * v.scaleX).toFixed(2);
      ellipse.setAttribute("d", `M ${-rx} 0 A ${rx} ${ry} 0 1 1 ${rx} 0 A ${rx} ${ry} 0 1 1 ${-rx} 0 Z`);
      ellipse.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)}) rotate(${(-turn * 180 / Math.PI).toFixed(2)})`);
    }

    function field(parts, name, value) { parts.push([name, value]); }

    function writeReadout(time) {
      const shown = estimate(), parts = [];
      const across = shown.x[moment], up = shown.y[moment];
      const x = replay.north_up ? up : across, y = replay.north_up ? across : up;
      field(parts, "time", `${time.toFixed(1)} s`);
      field(parts, replay.names[0], `${x.toFixed(2)} ${replay.unit}`);
      field(parts, replay.names[1], `${y.toFixed(2)} ${replay.unit}`);
      field(parts, "heading", `${(shown.world_heading[moment] * 180 / Math.PI).toFixed(1)}°`);
      if (shown.covariance && shown.covariance[0][moment] !== null) {
        const xx = shown.covariance[0][moment], xy = shown.covariance[1][moment], yy = shown.covariance[2][moment];
        field(parts, "σ", `${Math.sqrt(Math.max(0.5 * (xx + yy) + Math.hypot(0.5 * (xx - yy), xy), 0)).toFixed(3)} ${replay.unit}`);
      }
      if (shown.key === "final" && replay.error_m && replay.error_m[moment] !== null) field(parts, "error", `${replay.error_m[moment].toFixed(3)} ${replay.unit}`);
      if (replay.submap) field(parts, "submap", String(replay.submap[moment]));
      if (replay.landmarks) field(parts, "landmarks", `${countUpTo(replay.landmarks.time_s, time)} of ${replay.landmarks.time_s.length}`);
      if (replay.loops) field(parts, "loop closures", `${countUpTo(replay.loops.time_s, time)} of ${replay.loops.time_s.length}`);
      readout.replaceChildren(...parts.map(([name, value]) => {
        const span = document.createElement("span"), strong = document.createElement("b");
        strong.textContent = value; span.append(name + "\u2002", strong);
        return span;
      }));
    }

    function render() {
      if (!map._fullLayout) return;
      const v = viewOf(map), time = replay.time_s[moment];
      frame.classList.toggle("replaying", active);
      paintPast(v);
      drawVehicle(v);
      writeReadout(time);
    }

    function goTo(index) {
      moment = Math.max(0, Math.min(last, Math.round(index)));
      // at the end nothing is hidden any more: the whole map in full colour
      active = moment < last;
      slider.value = String(moment);
      slider.setAttribute("aria-valuetext", `${replay.time_s[moment].toFixed(1)} s`);
      render();
    }

    function step(now) {
      if (!playing) return;
      exact += (now - previous) / 1000 * last / Number(duration.value);
      previous = now;
      if (exact >= last) { goTo(last); stop(); return; }
      if (Math.floor(exact) !== moment) goTo(Math.floor(exact));
      requestAnimationFrame(step);
    }

    function stop() { playing = false; icon.setAttribute("d", PLAY_ICON); button.setAttribute("aria-label", "Play the mission"); }
    function play() {
      playing = true; icon.setAttribute("d", PAUSE_ICON); button.setAttribute("aria-label", "Pause");
      exact = moment >= last ? 0 : moment;
      requestAnimationFrame((now) => { previous = now; step(now); });
    }

    button.addEventListener("click", () => (playing ? stop() : play()));
    slider.addEventListener("input", () => { exact = Number(slider.value); goTo(exact); });
    choice.addEventListener("change", render);
    map.on("plotly_relayouting", render);
    map.on("plotly_afterplot", render);
    goTo(last);
  }

  function connectRows() {
    document.querySelectorAll("table.sortable").forEach((table) => {
      table.tBodies[0].addEventListener("click", (event) => {
        const row = event.target.closest("tr[data-x]");
        if (row) showOnMap(Number(row.dataset.x), Number(row.dataset.y));
      });
    });
    const refused = byId("show-refused");
    if (refused) refused.addEventListener("change", () => byId("loop-table").classList.toggle("hide-refused", !refused.checked));
  }

  connectTables();
  connectRows();
  connectPrint();
  const rest = Object.keys(report.figures).filter((id) => id !== "map").sort();
  draw("map")
    .then(() => {
      if (!drawn.map) return;
      connectLayers();
      tameWheel(byId("map"));
      fitMarks(byId("map"));
      byId("map").on("plotly_afterplot", () => fitMarks(byId("map")));
      byId("map").on("plotly_afterplot", () => keepDegreesInStep(byId("map")));
      keepDegreesInStep(byId("map"));
      byId("map").on("plotly_relayouting", placeFocusNow);
      if (report.replay) createReplay(report.replay);
    })
    .then(() => drawAll(rest));
})();
