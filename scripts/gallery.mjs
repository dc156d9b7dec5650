// node gallery.mjs TOP NAMES [CHROMIUM]: the page of all reports below TOP/build/gallery; with a browser,
// the pictures of the problems in NAMES and the page docs/gallery.md too. scripts/gallery calls it.
import {existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

const [top, names, browserPath] = process.argv.slice(2);
const gallery = join(top, 'build/gallery'), pictures = join(top, 'docs/images/gallery');
const escape = text => text.replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);
const problems = readdirSync(join(top, 'problems')).filter(f => f.endsWith('.yaml')).map(f => f.slice(0, -5)).sort();

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

function card(name) {
  const {solver, status, iterations} = JSON.parse(readFileSync(join(gallery, name, 'solution.json'), 'utf8'));
  return `<article><a href="${name}/report.html">
<h2>${name}</h2></a><p>${escape(story(name))}</p>
<p><small>${solver}: ${status}, ${iterations} iterations</small></p></article>`;
}

const solved = problems.filter(name => existsSync(join(gallery, name, 'solution.json')));
writeFileSync(join(gallery, 'index.html'), `<!DOCTYPE html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>conddp gallery</title>
<style>body{font:16px/1.5 system-ui,sans-serif;margin:20px auto;max-width:1100px;padding:0 14px;
color-scheme:light dark}main{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:14px}
article{border:1px solid #8886;border-radius:8px;padding:4px 14px}h2{font-size:18px;margin:10px 0 0}
p{margin:6px 0}</style><h1>Example problems</h1><main>${solved.map(card).join('\n')}</main></html>
`);
if (browserPath) {
  await draw(names.split(' '));
  describe();
}

/// A picture of each report's scene a little after the middle of its motion, of systems without one of their curves.
async function draw(drawn) {
  const {chromium} = await import('playwright-core');
  const browser = await chromium.launch({
    executablePath: browserPath,
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
  mkdirSync(pictures, {recursive: true});
  const open = async (name, viewport, share) => {
    const page = await browser.newPage({viewport, colorScheme: 'light', bypassCSP: true});
    page.on('pageerror', error => { throw error; });
    await page.goto(pathToFileURL(join(gallery, name, 'report.html')).href);
    await page.evaluate(at => window.conddp.player.seek(at * window.conddp.player.duration), share);
    return page;
  };
  for (const name of drawn) {
    const page = await open(name, {width: 820, height: 640}, 0.55);
    await page.addStyleTag({content: '.switches { display: none !important; } ' +
        '#view, #plots { height: 300px !important; width: 460px; overflow: hidden; }'});
    await page.waitForTimeout(200);  // until the view has its new size
    const scene = await page.evaluate(() => window.conddp.viewer.ready);
    if (scene) await page.evaluate(() => window.conddp.viewer.resetView());
    await page.locator(scene ? '#view' : '#plots').screenshot({path: join(pictures, `${name}.jpg`), type: 'jpeg', quality: 78});
    await page.close();
  }
  if (drawn.includes('quadruped_trot')) {
    const page = await open('quadruped_trot', {width: 1320, height: 860}, 0.55);
    await page.waitForTimeout(500);
    await page.screenshot({path: join(top, 'docs/images/report.png')});
  }
  await browser.close();
}

/// docs/gallery.md, of the problems that have a picture; pictures without a problem go.
function describe() {
  for (const file of readdirSync(pictures))
    if (!problems.includes(file.replace(/\.jpg$/, ''))) rmSync(join(pictures, file));
  const rows = problems.filter(name => existsSync(join(pictures, `${name}.jpg`))).map(name =>
      `| ![${name}](images/gallery/${name}.jpg) | **[${name}](../problems/${name}.yaml)** ${story(name).replaceAll('|', '\\|')} |`);
  writeFileSync(join(top, 'docs/gallery.md'), `# Gallery

Every example problem, from its own initial guess and with its own solver. \`scripts/conddp solve NAME --report\`
solves one of them and writes \`out/NAME/report.html\`. \`scripts/gallery\` solves all and makes a page with their
reports, \`build/gallery/index.html\`; \`scripts/gallery --screenshots\` draws the pictures below, and
\`scripts/gallery --check\` names problems without one.

| | |
|---|---|
${rows.join('\n')}
`);
}
