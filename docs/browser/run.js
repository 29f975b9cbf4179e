// Starts a worker that runs the simulation, and shows its result. A worker, so that the page stays responsive.

const part = (id) => document.getElementById(id);
const seed = new URLSearchParams(location.search).get("seed");
if (seed) part("seed").value = seed;
// The folder of Pyodide is no parameter, since a link could name a folder with other code.

let worker = null;
const deskRuns = fetch("desk.json").then((answer) => (answer.ok ? answer.json() : {})).catch(() => ({}));

part("settings").addEventListener("submit", (event) => {
  event.preventDefault();
  worker?.terminate();
  worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }) => (data.status ? showStatus(data.status, data.state) : showResult(data));
  worker.onerror = (error) => showStatus(`The worker failed: ${error.message}`, "error");
  const pyodide = new URL(part("pyodide").value.replace(/\/?$/, "/"), location.href).href;
  const wheel = new URL("robotcore.whl", location.href).href;
  worker.postMessage({ pyodide, wheel, seed: Number(part("seed").value) });
});

function showStatus(text, state = "busy") {
  part("status").textContent = text;
  part("status").dataset.state = state;
}

async function showResult(result) {
  const desk = (await deskRuns)[result.seed];
  part("outcome").textContent = result.reason ? `${result.outcome}: ${result.reason}` : result.outcome;
  part("time").textContent = `${result.sim_time_s.toFixed(1)} s in ${result.ticks} ticks`;
  part("digest").textContent = result.digest;
  part("desk").textContent = desk?.digest ?? `robotcore run green-search --seed ${result.seed} --json prints it`;
  part("comparison").textContent = desk ? compare(result, desk) : "";
  part("loading").textContent = `${(result.loading_ms / 1000).toFixed(1)} s`;
  part("duration").textContent = `${(result.run_ms / 1000).toFixed(1)} s`;
  part("notes").textContent = result.notes.join(" ");
  if (result.png) {
    part("picture").src = URL.createObjectURL(new Blob([result.png], { type: "image/png" }));
    part("picture").hidden = false;
  }
  part("result").hidden = false;
  showStatus("The run has ended.", "ended");
}

function compare(here, desk) {
  if (here.digest === desk.digest) return "The digests are equal.";
  return here.outcome === desk.outcome && here.ticks === desk.ticks
    ? "The digests differ. The outcome and the number of ticks are equal."
    : `The runs differ: ${desk.outcome} in ${desk.ticks} ticks on the desk.`;
}
