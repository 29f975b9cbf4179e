// Loads Pyodide and robotcore, runs green-search with a seed, and posts the result.

const PACKAGES = ["numpy", "opencv-python", "pydantic", "rich"];

const RUN = `
from robotcore import RunRequest, run
from robotcore.view.picture import PictureRecorder

recorder = PictureRecorder()
result = run(RunRequest("green-search", seed=seed), [recorder])
png = recorder.png()
outcome = result.outcome.value
`;

onmessage = async ({ data }) => {
  try {
    postMessage(await runApp(data));
  } catch (error) {
    postMessage({ status: `The run failed: ${error.message}`, state: "error" });
  }
};

async function runApp({ pyodide, wheel, seed }) {
  const begun = performance.now();
  postMessage({ status: `Loading Pyodide from ${pyodide} …` });
  const { loadPyodide } = await import(`${pyodide}pyodide.mjs`);
  const python = await loadPyodide({ indexURL: pyodide });
  postMessage({ status: `Loading ${PACKAGES.join(", ")} …` });
  await python.loadPackage(PACKAGES, { messageCallback: () => {} });
  postMessage({ status: "Loading robotcore …" });
  python.unpackArchive(await fetchWheel(wheel), "whl");
  await python.runPythonAsync("import robotcore.runtime.session, robotcore.view.picture");
  const loaded = performance.now();
  postMessage({ status: `Running green-search with the seed ${seed} …` });
  const names = python.toPy({ seed });
  await python.runPythonAsync(RUN, { globals: names });
  const result = names.get("result");
  return {
    seed,
    outcome: names.get("outcome"),
    reason: result.reason,
    sim_time_s: result.sim_time_s,
    ticks: result.ticks,
    digest: result.trace_sha256,
    notes: result.notes.toJs(),
    png: names.get("png")?.toJs(),
    loading_ms: loaded - begun,
    run_ms: performance.now() - loaded,
  };
}

async function fetchWheel(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address} answers ${answer.status}. Build the wheel, and copy it there`);
  return answer.arrayBuffer();
}
