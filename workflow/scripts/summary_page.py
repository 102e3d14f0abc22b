"""The summary of a batch as a page for a browser; it needs no server and nothing from elsewhere."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from costs import Prediction, size_of

if TYPE_CHECKING:
    from summary import Row

_STYLE = """
body { font: 15px/1.4 system-ui, sans-serif; margin: 1.5rem; color: #222; background: #fff; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .5rem .7rem; border-bottom: 1px solid #ddd; }
th { position: sticky; top: 0; background: #fff; }
img { max-width: 120px; max-height: 120px; border: 1px solid #ccc; background: #eee; }
td.number, th.number { text-align: right; white-space: nowrap; }
.word { font-weight: 600; padding: .1rem .5rem; border-radius: .3rem; white-space: nowrap; }
.good { background: #d9f2dd; } .fair { background: #fdf0c4; } .poor, .failed { background: #fbd9d5; }
.unfinished { background: #e4e4ee; }
fieldset { border: 0; padding: 0; margin: 1rem 0; } label { margin-right: 1rem; }
ul { margin: .2rem 0; padding-left: 1.1rem; } input[type=number] { width: 6rem; }
""".strip()

# One filter of three; and the prediction, from the mean costs in the page.
_SCRIPT = """
const rows = document.querySelectorAll("tbody tr");
function show() {
  const wanted = document.querySelector("input[name=show]:checked").value;
  let shown = 0;
  for (const row of rows) {
    row.hidden = wanted !== "all" && !row.dataset.groups.split(" ").includes(wanted);
    shown += row.hidden ? 0 : 1;
  }
  document.getElementById("shown").textContent = shown + " of " + rows.length;
}
document.querySelectorAll("input[name=show]").forEach((input) => input.addEventListener("change", show));
show();
const cost = JSON.parse(document.getElementById("cost").textContent);
function predict() {
  if (cost === null) return;
  const number = Number(document.getElementById("number").value);
  const atOnce = Math.max(1, Number(document.getElementById("at-once").value));
  const hours = (seconds) => (seconds === null ? "?" : (seconds * number / atOnce / 3600).toPrecision(3));
  document.getElementById("hours").textContent =
    hours(cost.seconds[0]) + " hours (" + hours(cost.seconds[1]) + " to " + hours(cost.seconds[2]) + ")";
  document.getElementById("disk").textContent = (cost.bytes * number / 1e9).toPrecision(3) + " GB";
  document.getElementById("memory").textContent = (cost.memory * atOnce / 1000).toPrecision(3) + " GB";
}
document.querySelectorAll("#number, #at-once").forEach((input) => input.addEventListener("input", predict));
predict();
""".strip()


def page_of(rows: Sequence[Row], prediction: Prediction | None, pictures: Sequence[str]) -> str:
    """The page; its links are relative to the folder of all results.

    Parameters
    ----------
    rows : sequence of Row
    prediction : Prediction or None
    pictures : sequence of str
        The pictures in a document's folder, each of which has a column.
    """
    head = ["document", *(picture.partition(".")[0] for picture in pictures), "quality", "to know", "seconds"]
    cells = "".join(f"<th{_number(name)}>{name}</th>" for name in head)
    body = "\n".join(_row(row, pictures) for row in rows)
    counts = {group: sum(group in _groups(row) for row in rows) for group in ("look", "poor", "failed")}
    choices = "".join(
        f'<label><input type="radio" name="show" value="{value}"{checked}> {text}</label>'
        for value, text, checked in (
            ("all", f"all {len(rows)}", " checked"),
            ("look", f"to look at: {counts['look']}", ""),
            ("poor", f"poor: {counts['poor']}", ""),
            ("failed", f"failed: {counts['failed']}", ""),
        )
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Batch of {len(rows)} documents</title>
<style>
{_STYLE}
</style>
<h1>Batch of {len(rows)} documents</h1>
{_costs(prediction)}
<fieldset>{choices}<span id="shown"></span></fieldset>
<table>
<thead><tr>{cells}</tr></thead>
<tbody>
{body}
</tbody>
</table>
<script type="application/json" id="cost">{_as_json(prediction)}</script>
<script>
{_SCRIPT}
</script>
</html>
"""


def _groups(row: Row) -> list[str]:
    """The choices above the table that show a document, besides that of all."""
    poor = row.state == "done" and row.quality == "poor"
    return ["look"] * row.look + ["poor"] * poor + ["failed"] * (row.state == "failed")


def _number(name: str) -> str:
    return ' class="number"' if name == "seconds" else ""


def _row(row: Row, pictures: Sequence[str]) -> str:
    folder = quote(row.document)
    name = f'<a href="./{folder}/">{escape(row.document)}</a>' if row.state == "done" else escape(row.document)
    word = row.quality if row.state == "done" else row.state
    style = {"not finished": "unfinished"}.get(word, word)
    groups = " ".join(_groups(row))
    known = [row.reason] if row.reason else [*row.measures, *row.warnings] if row.state == "done" else []
    sentences = "".join(f"<li>{escape(text)}</li>" for text in known)
    return "".join(
        [
            f'<tr data-groups="{groups}"><td>{name}</td>',
            *(f"<td>{_picture(row, folder, picture)}</td>" for picture in pictures),
            f'<td><span class="word {style}">{escape(word)}</span></td>',
            f"<td>{f'<ul>{sentences}</ul>' if sentences else ''}</td>",
            f'<td class="number">{row.figures.get("seconds") or 0:.0f}</td></tr>',
        ]
    )


def _picture(row: Row, folder: str, picture: str) -> str:
    small = row.pictures.get(picture)
    if small is None:
        return ""
    text = escape(f"{picture.partition('.')[0]} of {row.document}")
    return f'<a href="./{folder}/{picture}"><img loading="lazy" src="./{quote(small)}" alt="{text}"></a>'


def _costs(prediction: Prediction | None) -> str:
    if prediction is None:
        return "<p>No document has run yet.</p>"
    total = prediction.total
    return f"""<p>{prediction.documents} documents took {total["seconds"] / 3600:.2f} hours of computers \
({total["cpu_seconds"] / 3600:.2f} hours of processors), at most {prediction.memory_mb:.0f} MB of memory in a process; \
they read {size_of(total["read_bytes"])} and wrote {size_of(total["written_bytes"])}, of which \
{size_of(total["results_bytes"])} are results.</p>
<p>A collection of <input type="number" id="number" value="1000" min="1"> such documents,
<input type="number" id="at-once" value="2" min="1"> at once, would take <b id="hours"></b>,
<b id="disk"></b> of disk for the results and <b id="memory"></b> of memory.</p>"""


def _as_json(prediction: Prediction | None) -> str:
    if prediction is None:
        return "null"
    mean = prediction.seconds
    seconds: list[Any] = [value if math.isfinite(value) else None for value in (mean.value, mean.least, mean.most)]
    return json.dumps(
        {"seconds": seconds, "bytes": prediction.results_bytes.value, "memory": prediction.memory_mb}, allow_nan=False
    )
