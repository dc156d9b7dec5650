import {batchSection} from './batch.js';
import {benchTable} from './bench.js';
import {readData} from './data.js';
import {element, isTyping} from './dom.js';
import {loopSection, writeLoopFoot, writeLoopHead} from './loop.js';
import {Player} from './player.js';
import {makePlots} from './plots.js';
import {recordForTool} from './recording.js';
import {comparisonTable, standIns, writeFoot, writeHead} from './summary.js';
import {Timeline} from './timeline.js';
import {Viewer} from './viewer.js';

const byId = id => document.getElementById(id);
const root = document.documentElement;

/// Shows motion and plots of the solutions, or of a closed loop's plant. Returns the objects behind
/// them.
function showSolutions(solutions, loop, setThemeOf) {
  const player = new Player(Math.max(...solutions.map(s => s.duration)));
  let plots = [];
  if (solutions.length > 1)
    byId('head').append(comparisonTable(solutions, visible => {
      viewer.setVisible(visible);
      for (const plot of plots) plot.setVisible(visible);
    }));
  const viewer = new Viewer(byId('view'), solutions, player, loop?.plans);
  new Timeline(byId('timeline'), solutions[0], player, loop?.events);
  byId('stage').append(standIns(solutions) ?? '');
  plots = makePlots(byId('plots'), solutions, player, loop);
  setThemeOf.push(viewer, ...plots);
  return {player, viewer, plots};
}

function start() {
  const {solutions, bench, batch, loop} = readData();
  root.dataset.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';

  const themed = [];
  const setTheme = theme => {
    root.dataset.theme = theme;
    for (const part of themed) part.setTheme();
  };
  const changeTheme = () => setTheme(root.dataset.theme === 'dark' ? 'light' : 'dark');
  const themeButton = element('button', {type: 'button', class: 'theme', id: 'theme',
                                         title: 'Dark or light (D)', onclick: changeTheme}, '◐');
  if (loop) writeLoopHead(byId('head'), solutions[0], themeButton);
  else writeHead(byId('head'), batch?.name, solutions, themeButton);
  const main = document.querySelector('main');
  if (batch) main.before(batchSection(batch));
  // A batch without solutions also has a page.
  const shown = solutions.length > 0 ? showSolutions(solutions, loop, themed) : null;
  if (!shown) main.remove();
  if (bench) byId('foot').append(benchTable(bench));
  if (loop) {
    byId('foot').append(loopSection(solutions[0], loop));
    writeLoopFoot(byId('foot'), solutions[0]);
  } else {
    writeFoot(byId('foot'), solutions);
  }
  document.addEventListener('keydown', event => {
    if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event)) return;
    if (event.key === 'f' || event.key === 'F') shown?.viewer.followButton?.click();
    if (event.key === 'd' || event.key === 'D') changeTheme();
  });
  // Prints use the light theme.
  let onScreen = root.dataset.theme;
  window.addEventListener('beforeprint', () => {
    onScreen = root.dataset.theme;
    setTheme('light');
  });
  window.addEventListener('afterprint', () => setTheme(onScreen));
  // Access for scripts, and for the tool.
  window.conddp = {solutions, batch, loop, ...shown, record: (...size) => recordForTool(shown.viewer, ...size)};
}

start();
