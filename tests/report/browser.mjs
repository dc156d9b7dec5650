// Helpers of the browser tests. CONDDP names the tool, CONDDP_SOURCE the source tree, CONDDP_CHROMIUM
// the browser.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before} from 'node:test';
import {pathToFileURL} from 'node:url';
import {chromium} from 'playwright-core';

const tool = process.env.CONDDP;
export const source = process.env.CONDDP_SOURCE;
/// Folder for the files of one test run.
export const folder = mkdtempSync(join(tmpdir(), 'conddp_report_'));
let browser;

before(async () => {
  browser = await chromium.launch({
    executablePath: process.env.CONDDP_CHROMIUM,
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync', '--use-angle=swiftshader',
           '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
});

after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true, force: true});
});

/// Runs the tool. Exit status 1 means an answer that did not converge.
export function run(...args) {
  const {status, stderr} = spawnSync(tool, args, {encoding: 'utf8', cwd: source});
  assert.ok(status === 0 || status === 1, stderr);
}

/// Solves a problem; returns its answer and the report's file.
export function solve(problem, name, ...options) {
  const out = join(folder, name);
  run('solve', problem, '-o', out, '--report', ...options);
  return {
    solution: JSON.parse(readFileSync(join(out, 'solution.json'), 'utf8')),
    json: join(out, 'solution.json'),
    page: join(out, 'report.html'),
  };
}

/// Waits for a condition in the page. (Playwright's own method evaluates text, which the page forbids.)
export async function until(page, condition) {
  for (let tries = 0; tries < 400; ++tries) {
    if (await page.evaluate(condition)) return;
    await page.waitForTimeout(25);
  }
  assert.fail(`never: ${condition}`);
}

/// Opens a page and records its complaints and network requests.
export async function open(file, options = {}) {
  const context = await browser.newContext({viewport: {width: 1280, height: 900}, ...options});
  const page = await context.newPage();
  const complaints = [], requests = [];
  page.on('console', message => {
    if (message.type() === 'error' || message.type() === 'warning') complaints.push(message.text());
  });
  page.on('pageerror', error => complaints.push(String(error)));
  page.on('request', request => {
    if (!/^(file|data|blob):/.test(request.url())) requests.push(request.url());
  });
  await page.goto(pathToFileURL(file).href);
  await until(page, () => window.conddp !== undefined);
  return {page, context, complaints, requests};
}

/// A WebM video as a player sees it: size, number of frames at 30 a second, and whether its picture changes
/// from the start to the middle and to the end.
export async function watch(bytes) {
  const page = await browser.newPage();
  const seen = await page.evaluate(async base64 => {
    const video = document.createElement('video'), canvas = document.createElement('canvas');
    const happens = name => new Promise((done, fail) => {
      video.addEventListener(name, done, {once: true});
      video.addEventListener('error', () => fail(new Error(video.error.message)), {once: true});
    });
    video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(base64), c => c.charCodeAt(0))], {type: 'video/webm'}));
    await happens('loadeddata');
    const {videoWidth: width, videoHeight: height, duration} = video;
    Object.assign(canvas, {width, height});
    const pictures = [];
    for (const share of [0, 0.5, 1]) {
      const sought = happens('seeked');
      video.currentTime = share * duration;
      await sought;
      canvas.getContext('2d').drawImage(video, 0, 0);
      pictures.push(canvas.toDataURL());
    }
    return {width, height, frames: Math.round(30 * duration), changes: new Set(pictures).size === 3};
  }, bytes.toString('base64'));
  await page.close();
  return seen;
}

/// Complaints of the software renderer about itself are ignored.
export const ours = complaints => complaints.filter(text => !/GPU stall|swiftshader|GL Driver Message/i.test(text));
