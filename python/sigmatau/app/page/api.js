// Requests to the server, one function each; an error of the server is thrown as an ApiError.

const BASE = new URL("./", location.href);
const POLL = 150; // interval between requests for the state of a job [ms]

/** An error of the server: `hints` are options that correct it, `rows` the first rows of the file. */
export class ApiError extends Error {
  constructor(content, status) {
    super(content.message);
    this.hints = content.hint ?? [];
    this.rows = content.rows ?? "";
    this.code = content.code;
    this.status = status;
  }
}

async function send(method, path, body, signal) {
  try {
    return await fetch(new URL(`api/${path}`, BASE), {
      method, signal, headers: body === undefined ? {} : { "Content-Type": "application/json" }, body: body === undefined ? undefined : JSON.stringify(body),
    });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new ApiError({ message: "The server does not answer: start sigmatau app again.", code: "gone" }, 0);
  }
}

async function call(method, path, body, signal) {
  return content(await send(method, path, body, signal));
}

async function content(response) {
  const text = await response.text();
  let answer;
  try {
    answer = text ? JSON.parse(text) : {};
  } catch {
    throw new ApiError({ message: `The server answered with status ${response.status} and no JSON.`, code: "failed" }, response.status);
  }
  if (!response.ok) throw new ApiError(answer.error ?? { message: `The server answered with status ${response.status}.` }, response.status);
  return answer;
}

export const about = () => call("GET", "about");
export const files = (path) => call("GET", path ? `files?path=${encodeURIComponent(path)}` : "files");
export const open = (source, options, signal) => call("POST", "open", { ...source, options }, signal);
export const envelope = (source, options, range, signal) => call("POST", "envelope", { ...source, options, channel: null, from_s: null, to_s: null, ...range }, signal);
export const result = (id) => call("GET", `results/${encodeURIComponent(id)}`);
export const charts = (id) => call("GET", `results/${encodeURIComponent(id)}/charts`);
export const readOff = (id, body, signal) => call("POST", `results/${encodeURIComponent(id)}/read-off`, body, signal);
export const exported = (id, target, choices, { inflate, turnOn }) => call("POST", "export", { result: id, target, choices, inflate, turn_on: turnOn });
export const compare = (results) => call("POST", "compare", { results });
export const runs = (source, unit) => call("POST", "runs", { ...source, unit });
export const openRun = (source, run) => call("POST", "runs/open", { ...source, run });
export const datasheets = () => call("GET", "datasheets");
export const specification = (named, { use, sided, bias }) => call("POST", "specification", { ...named, use: use || null, sided: sided || null, bias: bias || null });
export const figureFacts = (source, page) => call("POST", "figure", { ...source, page });

/** The picture of a figure, a Blob. */
export async function figurePicture(source, page) {
  const response = await send("POST", "figure/picture", { ...source, page });
  return response.ok ? response.blob() : content(response);
}

export const figureCurves = (body, signal) => call("POST", "figure/curves", body, signal);
export const config = (body) => call("POST", "config", body);
export const live = () => call("GET", "live");
export const ports = () => call("GET", "ports");
export const startLive = (body) => call("POST", "live/start", body);
export const changeLiveOptions = (options) => call("POST", "live/options", { options });
export const liveColumns = (options) => call("POST", "live/columns", { options });
export const stopLive = () => call("POST", "live/stop", {});
export const fileAddress = (id, name) => new URL(`api/results/${encodeURIComponent(id)}/${name}`, BASE).href;

/** Start an analysis and wait for it; `progress` is called with every state of the job. Returns the id of the result. */
export async function analyze(source, options, progress, signal) {
  const { job } = await call("POST", "analyze", { ...source, options });
  const stop = () => call("DELETE", `jobs/${encodeURIComponent(job)}`).catch(() => {});
  for (;;) {
    if (signal.aborted) {
      await stop();
      throw new DOMException("cancelled", "AbortError");
    }
    const state = await call("GET", `jobs/${encodeURIComponent(job)}`);
    progress(state);
    if (state.state === "done") return state.result;
    if (state.state === "failed") throw new ApiError(state.error?.error ?? state.error ?? { message: "The analysis failed." }, 422);
    if (state.state === "cancelled") throw new DOMException("cancelled", "AbortError");
    await new Promise((resolve) => setTimeout(resolve, POLL));
  }
}

/** Upload a file; `progress` is called with the uploaded share. Returns {file, name, bytes}. */
export function upload(file, progress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", new URL(`api/upload?name=${encodeURIComponent(file.name)}`, BASE));
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.upload.onprogress = (event) => event.lengthComputable && progress(event.loaded / event.total);
    request.onerror = () => reject(new ApiError({ message: "The file could not be sent to the server.", code: "gone" }, 0));
    request.onload = () => {
      let content = {};
      try {
        content = JSON.parse(request.responseText);
      } catch { /* the error below states the status */ }
      if (request.status < 300) resolve(content);
      else reject(new ApiError(content.error ?? { message: `The server answered with status ${request.status}.` }, request.status));
    };
    request.send(file);
  });
}

export const forgetUpload = (id) => call("DELETE", `upload/${encodeURIComponent(id)}`).catch(() => {});
