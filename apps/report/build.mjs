// Bundles the page of `conddp report` into a single self-contained file: node build.mjs OUT.html
// Runs in this folder, or in a copy of it, with its packages installed.
import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';
import {build} from 'esbuild';

const out = process.argv[2] ?? 'report.html';
const options = {bundle: true, minify: true, write: false, legalComments: 'inline', target: 'es2020'};
const script = await build({...options, entryPoints: ['src/main.js'], format: 'iife'});
const style = await build({...options, entryPoints: ['src/style.css']});

const page = readFileSync('index.html', 'utf8');
const fill = (text, mark, content) => {
  const parts = text.split(mark);
  if (parts.length !== 2) throw new Error(`index.html should have ${mark} once`);
  return parts.join(content);
};
// The page's policy lists the hashes of its script and style, so that no others can run.
const hash = text => `sha256-${createHash('sha256').update(text, 'utf8').digest('base64')}`;
let filled = page;
for (const [mark, text] of [['SCRIPT', script.outputFiles[0].text], ['STYLE', style.outputFiles[0].text]])
  filled = fill(fill(filled, `/*${mark}-HASH*/`, hash(text)), `/*${mark}*/`, text);
writeFileSync(out, filled);
