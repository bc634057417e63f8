// Draws the figures that page.cpp describes, and makes tables sortable. Without scripts, the tables show the same numbers.
(function () {
  'use strict';
  var ink = '#17212b', muted = '#4a5763', grid = '#dfe4e9';
  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  Chart.defaults.color = ink;
  Chart.defaults.animation = false;

  function label(ctx, text, x, y, align, colour) {
    ctx.textAlign = align;
    ctx.lineJoin = 'round';
    ctx.lineWidth = 3;
    ctx.strokeStyle = 'rgba(255,255,255,.85)';
    ctx.strokeText(text, x, y);
    ctx.fillStyle = colour;
    ctx.fillText(text, x, y);
  }

  // Bands, spans and lines behind the curves.
  function behind(chart, spec) {
    var ctx = chart.ctx, area = chart.chartArea, x = chart.scales.x, y = chart.scales.y;
    ctx.save();
    ctx.font = '12px ' + Chart.defaults.font.family;
    ctx.textBaseline = 'middle';
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.width, area.height);
    ctx.clip();
    (spec.bands || []).forEach(function (band) {
      var left = x.getPixelForValue(band.from), width = x.getPixelForValue(band.to) - left;
      ctx.fillStyle = band.colour;
      ctx.fillRect(left, area.top, width, area.height);
      var long = ctx.measureText(band.text).width;
      ctx.fillStyle = muted;
      ctx.textAlign = 'center';
      if (long + 8 < width) {
        ctx.fillText(band.text, left + width / 2, area.top + 12);
      } else if (width > 13) {
        ctx.save();
        ctx.translate(left + width / 2, area.top + 8 + long / 2);
        ctx.rotate(-Math.PI / 2);
        ctx.fillText(band.text, 0, 0);
        ctx.restore();
      }
    });
    (spec.spans || []).forEach(function (span) {
      var left = x.getPixelForValue(span.from), right = x.getPixelForValue(span.to);
      var middle = y.getPixelForValue(span.lane);
      var half = Math.abs(y.getPixelForValue(0.32) - y.getPixelForValue(0));
      ctx.fillStyle = span.colour;
      ctx.fillRect(left, middle - half, Math.max(1.5, right - left), 2 * half);
      if (span.text && ctx.measureText(span.text).width + 6 < right - left) {
        ctx.fillStyle = ink;
        ctx.textAlign = 'center';
        ctx.fillText(span.text, (left + right) / 2, middle);
      }
    });
    (spec.boxes || []).forEach(function (box) {
      var middle = x.getPixelForValue(box.x), half = Math.min(40, (x.getPixelForValue(box.x + 0.25) - middle));
      var at = function (value) { return y.getPixelForValue(value); };
      var bar = function (value, wide) { ctx.moveTo(middle - wide, at(value)); ctx.lineTo(middle + wide, at(value)); };
      ctx.fillStyle = box.colour + '33';
      ctx.strokeStyle = box.colour;
      ctx.lineWidth = 1.5;
      ctx.fillRect(middle - half, at(box.upper), 2 * half, at(box.lower) - at(box.upper));
      ctx.strokeRect(middle - half, at(box.upper), 2 * half, at(box.lower) - at(box.upper));
      ctx.beginPath();
      bar(box.low, half / 2);
      bar(box.high, half / 2);
      ctx.moveTo(middle, at(box.low));
      ctx.lineTo(middle, at(box.lower));
      ctx.moveTo(middle, at(box.upper));
      ctx.lineTo(middle, at(box.high));
      ctx.stroke();
      ctx.lineWidth = 3;
      ctx.beginPath();
      bar(box.median, half);
      ctx.stroke();
    });
    (spec.lines || []).forEach(function (line) {
      var at = y.getPixelForValue(line.y);
      ctx.strokeStyle = muted;
      ctx.lineWidth = 1.5;
      ctx.setLineDash([6, 4]);
      ctx.beginPath();
      ctx.moveTo(area.left, at);
      ctx.lineTo(area.right, at);
      ctx.stroke();
      ctx.setLineDash([]);
      if (!spec.boxes) label(ctx, line.text, area.right - 4, at - 9, 'right', muted);
    });
    ctx.restore();
  }

  // Marks and their texts, in front of the curves. A text that would touch another one is moved up. In a box plot, the
  // lines' texts too: they stand right of the boxes, because they would cover the last one.
  function inFront(chart, spec) {
    var ctx = chart.ctx, area = chart.chartArea, x = chart.scales.x, y = chart.scales.y, taken = [];
    ctx.save();
    ctx.font = '12px ' + Chart.defaults.font.family;
    ctx.textBaseline = 'middle';
    if (spec.boxes) (spec.lines || []).forEach(function (line) {
      line.text.split(': ').forEach(function (part, row) {
        label(ctx, part, area.right + 6, y.getPixelForValue(line.y) + 15 * row - 7, 'left', muted);
      });
    });
    ctx.font = 'bold 12px ' + Chart.defaults.font.family;
    (spec.marks || []).forEach(function (mark) {
      var text = mark.text.length > 40 ? mark.text.slice(0, 39) + '…' : mark.text;
      var px = x.getPixelForValue(mark.x), py = y.getPixelForValue(mark.y);
      ctx.lineWidth = 2;
      ctx.strokeStyle = ink;
      ctx.fillStyle = '#ffffff';
      ctx.beginPath();
      ctx.arc(px, py, 4, 0, 2 * Math.PI);
      ctx.fill();
      ctx.stroke();
      var wide = ctx.measureText(text).width;
      var left = Math.max(area.left + 2, Math.min(px + 7, area.right - wide - 2)), top = py - 12;
      for (var turn = 0; turn < taken.length; ++turn)
        taken.forEach(function (t) {
          if (left < t.right + 4 && left + wide > t.left - 4 && Math.abs(top - t.top) < 15) top = t.top - 15;
        });
      top = Math.max(area.top + 28, top);
      taken.push({left: left, right: left + wide, top: top});
      label(ctx, text, left, top, 'left', ink);
    });
    ctx.restore();
  }

  function scale(axis, lanes) {
    var s = {type: 'linear', title: {display: !!axis.title, text: axis.title || ''}, grid: {color: grid, drawTicks: true}};
    if (axis.min !== undefined) s.min = axis.min;
    if (axis.max !== undefined) s.max = axis.max;
    s.ticks = {includeBounds: false};  // no tick at an end of the axis that is not a round number
    if (axis.whole) s.ticks = {includeBounds: false, callback: function (v) { return Number.isInteger(v) ? v : ''; }};
    if (axis.names) {
      s.min = -0.6;
      s.max = axis.names.length - 0.4;
      s.reverse = lanes;
      s.grid = {display: false};
      s.afterBuildTicks = function (a) { a.ticks = axis.names.map(function (n, i) { return {value: i}; }); };
      s.ticks = {autoSkip: !lanes, callback: function (v) { return axis.names[v] || ''; }};
    }
    return s;
  }

  function dataset(series) {
    var bar = series.shape === 'line';
    return {
      label: series.name,
      data: series.points.map(function (p) { return {x: p[0], y: p[1], text: p[2]}; }),
      showLine: !!series.line, borderColor: series.colour, backgroundColor: series.colour,
      borderWidth: series.width || 2, borderDash: series.dash || [],
      pointStyle: series.shape || 'circle', pointRadius: bar ? 16 : series.small ? 1.5 : series.shape ? 5 : 0, pointHitRadius: bar ? 0 : 6,
      pointBorderColor: series.shape && !bar && !series.small ? '#ffffff' : series.colour, pointBorderWidth: bar ? 3 : 1, tension: 0, spanGaps: false, clip: 6,
      order: series.dash && series.dash.length ? -1 : 0  // dashed curves on top, so that equal curves below stay visible
    };
  }

  function tip(spec) {
    return function (item) {
      var p = item.raw, text = item.dataset.label;
      if (p.text) return text + ': ' + p.text;
      var name = spec.x.names ? spec.x.names[p.x] : p.x;
      return text + ': ' + p.y + ' at ' + name;
    };
  }

  // The y axis. Texts of marks need room above the points.
  function upright(spec) {
    var s = scale(spec.y, true);
    if (spec.marks && spec.y.max === undefined) s.grace = '8%';
    return s;
  }

  function draw(canvas, spec) {
    var shown = Object.assign({}, spec, spec.choices ? spec.choices[0] : {});
    var chart = new Chart(canvas, {
      type: 'scatter',
      data: {datasets: shown.series.map(dataset)},
      options: {
        maintainAspectRatio: false, responsive: true,
        layout: {padding: {right: spec.boxes && spec.lines ? 104 : 0}},
        interaction: {mode: 'nearest', intersect: true},
        scales: {x: scale(shown.x, false), y: upright(shown)},
        plugins: {
          legend: {display: shown.series.length > 1, position: 'top', align: 'start',
                   labels: {usePointStyle: true, boxHeight: 9, padding: 14, pointStyleWidth: shown.series.every(function (s) { return !s.shape; }) ? 28 : undefined,
                            generateLabels: function (c) {
                              return Chart.defaults.plugins.legend.labels.generateLabels(c).map(function (item) {
                                var d = c.data.datasets[item.datasetIndex];
                                if (d.showLine && !d.pointRadius) item.pointStyle = 'line';
                                item.strokeStyle = d.borderColor;
                                item.lineDash = d.borderDash;
                                item.lineWidth = d.borderWidth;
                                return item;
                              });
                            }}},
          tooltip: {callbacks: {label: tip(shown), title: function () { return ''; }}}
        }
      },
      plugins: [{
        id: 'stylet',
        beforeDatasetsDraw: function (c) { behind(c, shown); },
        afterDatasetsDraw: function (c) { inFront(c, shown); }
      }]
    });
    // Resizes the chart to the width of a sheet of paper. page.css sets the same width for printing.
    addEventListener('beforeprint', function () {
      chart.resize(640, canvas.parentNode.classList.contains('low') ? 250 : 340);
    });
    addEventListener('afterprint', function () { chart.resize(); });
    if (!spec.choices) return;
    var choice = document.getElementById(canvas.id + '-choice');
    choice.parentNode.hidden = false;
    choice.addEventListener('change', function () {
      shown = Object.assign(shown, spec.choices[choice.selectedIndex]);
      chart.data.datasets = shown.series.map(dataset);
      chart.options.scales.y = upright(shown);
      chart.update();
    });
  }

  document.querySelectorAll('script.figure').forEach(function (data) {
    draw(document.getElementById(data.getAttribute('data-for')), JSON.parse(data.textContent));
  });

  // Turns the head cells into buttons that sort. A cell's value is data-sort or else its text. Cells that should be
  // numbers but are not come first.
  document.querySelectorAll('table.sortable').forEach(function (table) {
    var heads = Array.prototype.slice.call(table.tHead.rows[0].cells), body = table.tBodies[0];
    heads.forEach(function (head, column) {
      var button = document.createElement('button');
      button.type = 'button';
      while (head.firstChild) button.appendChild(head.firstChild);
      head.appendChild(button);
      button.addEventListener('click', function () {
        var down = head.getAttribute('aria-sort') === 'ascending';
        heads.forEach(function (other) { other.removeAttribute('aria-sort'); });
        head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
        var value = function (row) {
          var cell = row.cells[column], text = cell.getAttribute('data-sort') || cell.textContent, number = parseFloat(text);
          return cell.classList.contains('n') ? (isNaN(number) ? -Infinity : number) : text;
        };
        Array.prototype.slice.call(body.rows).sort(function (a, b) {
          var p = value(a), q = value(b), order = p < q ? -1 : p > q ? 1 : 0;
          return down ? -order : order;
        }).forEach(function (row) { body.appendChild(row); });
      });
    });
  });
})();
