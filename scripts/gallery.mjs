// node gallery.mjs TOP [CHROMIUM]: the page of all reports below TOP/build/gallery; with a browser, the
// pictures and the page docs/gallery.md too. scripts/gallery calls it.
import {mkdirSync, readdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

const [top, browserPath] = process.argv.slice(2);
const gallery = join(top, 'build/gallery');
const escape = text => text.replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);

/// The comment at the head of a problem file.
function story(name) {
  const lines = readFileSync(join(top, 'problems', `${name}.yaml`), 'utf8').split('\n');
  const text = [];
  for (const line of lines) {
    if (!line.startsWith('#')) break;
    if (!line.includes('yaml-language-server')) text.push(line.replace(/^#\s?/, ''));
  }
  return text.join(' ').replace(/\s+/g, ' ').trim();
}

const entries = readdirSync(gallery, {withFileTypes: true}).filter(e => e.isDirectory()).map(({name}) => {
  const solution = JSON.parse(readFileSync(join(gallery, name, 'solution.json'), 'utf8'));
  return {name, story: story(name), status: solution.status, iterations: solution.iterations,
          solver: solution.solver, duration: solution.problem.duration_s};
});

const cards = entries.map(e => `<article><a href="${e.name}/report.html">
<h2>${e.name}</h2></a><p>${escape(e.story)}</p>
<p><small>${e.solver}: ${e.status}, ${e.iterations} iterations</small></p></article>`);
writeFileSync(join(gallery, 'index.html'), `<!DOCTYPE html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>conddp gallery</title>
<style>body{font:16px/1.5 system-ui,sans-serif;margin:20px auto;max-width:1100px;padding:0 14px;
color-scheme:light dark}main{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:14px}
article{border:1px solid #8886;border-radius:8px;padding:4px 14px}h2{font-size:18px;margin:10px 0 0}
p{margin:6px 0}</style><h1>Ready problems</h1><main>${cards.join('\n')}</main></html>
`);

if (browserPath) await draw();

async function draw() {
  const {chromium} = await import('playwright-core');
  const browser = await chromium.launch({
    executablePath: browserPath,
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
  const images = join(top, 'docs/images');
  mkdirSync(join(images, 'gallery'), {recursive: true});
  const open = async (name, viewport) => {
    const page = await browser.newPage({viewport, colorScheme: 'light'});
    await page.goto(pathToFileURL(join(gallery, name, 'report.html')).href);
    return page;
  };
  for (const {name, duration} of entries) {
    const page = await open(name, {width: 820, height: 640});
    await page.addStyleTag({content: '.switches { display: none !important; } #view { height: 300px !important; width: 460px; }'})
        .catch(() => {});
    await page.evaluate(t => window.conddp.player.seek(t), 0.55 * duration);
    await page.waitForTimeout(150);
    await page.locator('#view').screenshot({path: join(images, 'gallery', `${name}.jpg`), type: 'jpeg', quality: 78});
    await page.close();
  }
  const page = await open('quadruped_trot', {width: 1320, height: 860});
  await page.evaluate(() => window.conddp.player.seek(0.7));
  await page.waitForTimeout(300);
  await page.screenshot({path: join(images, 'report.png')});
  await browser.close();

  const rows = entries.map(e => `| ![${e.name}](images/gallery/${e.name}.jpg) | **[${e.name}](../problems/${e.name}.yaml)** ${e.story} |`);
  writeFileSync(join(top, 'docs/gallery.md'), `# Gallery

Every ready problem, at its own initial guess and solver. \`scripts/gallery\` solves them all and makes a
page with their reports, \`build/gallery/index.html\`; \`scripts/gallery --screenshots\` draws the pictures
below. One of them alone: \`scripts/conddp solve problems/NAME.yaml --report\`, then open
\`out/NAME/report.html\`.

| | |
|---|---|
${rows.join('\n')}
`);
}
