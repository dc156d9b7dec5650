// Elements without markup: text from a problem file always remains text.

export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name === 'class') node.className = value;
    else if (value !== null && value !== undefined) node.setAttribute(name, value);
  }
  for (const child of children)
    if (child !== null && child !== undefined) node.append(child);
  return node;
}

/// A table of texts; marked rows are highlighted.
export function table(id, names, rows, marked = () => false) {
  return element('div', {class: 'wide'}, element('table', {id},
      element('thead', {}, element('tr', {}, ...names.map(n => element('th', {}, n)))),
      element('tbody', {}, ...rows.map((cells, i) => element('tr', marked(i) ? {class: 'violated'} : {},
          ...cells.map(cell => element('td', {}, cell instanceof Node ? cell : String(cell ?? ''))))))));
}

/// A toggle button.
export function toggle(label, title, on, change) {
  const button = element('button', {type: 'button', title, 'aria-pressed': String(on)}, label);
  button.addEventListener('click', () => {
    const now = button.getAttribute('aria-pressed') !== 'true';
    button.setAttribute('aria-pressed', String(now));
    change(now);
  });
  return button;
}

/// The value of a style-sheet color, which depends on the theme.
export const color = name =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/// A number formatted for users.
export function figure(value, digits = 5) {
  if (typeof value !== 'number' || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits)));
  return value.toExponential(Math.max(0, Math.min(digits, 4) - 1));
}

/// An SVG element.
export function shape(tag, attributes = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes))
    if (value !== null && value !== undefined) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/// True if a key is input of a field.
export const isTyping = event => /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName);

/// A selection list; `names` are in the order of their numbers.
export function choice(label, names, chosen, change) {
  const select = element('select', {'aria-label': label, onchange: () => change(Number(select.value))},
      ...names.map((name, i) => element('option', i === chosen ? {value: i, selected: ''} : {value: i}, name)));
  return element('label', {}, `${label} `, select);
}
