'use strict';
// Sorting: the header of a column becomes a button; empty cells stay last either way.
const sortable = (root) => {
  for (const table of root.querySelectorAll('table.sortable, table.checks')) {
    const body = table.tBodies[0];
    [...table.tHead.rows[0].cells].forEach((header, column) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.append(...header.childNodes);
      header.append(button);
      button.addEventListener('click', () => {
        const sign = header.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
        for (const other of table.tHead.rows[0].cells) other.removeAttribute('aria-sort');
        header.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending');
        const key = (row) => {
          const cell = row.cells[column];
          if (!cell) return '';
          const number = cell.dataset.value ?? cell.querySelector('.number')?.title ?? '';
          return number === '' || isNaN(number) ? cell.textContent.trim() : Number(number);
        };
        const compare = (a, b) => {
          if (a === '' || b === '') return (a === '') - (b === '');
          if (typeof a === 'number' && typeof b === 'number') return sign * (a < b ? -1 : a > b ? 1 : 0);
          if (typeof a === typeof b) return sign * a.localeCompare(b, 'en', { numeric: true });
          return typeof a === 'number' ? -1 : 1;
        };
        const rows = [...body.rows].map((row) => [key(row), row]);
        rows.sort((a, b) => compare(a[0], b[0]));
        body.append(...rows.map((pair) => pair[1]));
      });
    });
  }
};
sortable(document);
// A map is one stop of the keyboard, and the arrow keys go from cell to cell.
for (const map of document.querySelectorAll('table.grid')) {
  const links = [...map.querySelectorAll('td a')];
  links.forEach((link, place) => { link.tabIndex = place ? -1 : 0; });
  const place = (link) => [link.closest('tr').sectionRowIndex, link.parentElement.cellIndex];
  const steps = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] };
  map.addEventListener('keydown', (event) => {
    const step = steps[event.key];
    if (!step || !event.target.matches('td a')) return;
    event.preventDefault();
    const rows = map.tBodies[0].rows;
    let [row, column] = place(event.target);
    let next;
    // Over blank cells to the next one that leads somewhere.
    do {
      row += step[0];
      column += step[1];
      next = rows[row]?.cells[column]?.querySelector('a');
    } while (!next && rows[row]?.cells[column]);
    if (!next) return;
    event.target.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
}
// A large part travels compressed and is unpacked once, when it is opened.
const unpack = async (part) => {
  const packed = part.querySelector(':scope > .packed');
  if (!packed) return;
  packed.remove();
  const bytes = Uint8Array.from(atob(packed.textContent), (c) => c.charCodeAt(0));
  const text = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  const body = document.createElement('div');
  body.innerHTML = await new Response(text).text();
  sortable(body);
  part.append(body);
};
const packed = () => [...document.querySelectorAll('.packed')].map((data) => data.parentElement);
packed().forEach((part) => part.addEventListener('toggle', () => unpack(part)));
// A link into a folded part unfolds it, and unpacks it; the chapter that the name begins with comes first.
const reveal = async () => {
  const id = decodeURIComponent(location.hash.slice(1));
  if (!id) return;
  const isHere = (part) => id.startsWith(`${part.closest('.chapter')?.id}/`);
  const parts = packed().sort((a, b) => isHere(b) - isHere(a));
  let target = document.getElementById(id);
  while (!target && parts.length) {
    await unpack(parts.shift());
    target = document.getElementById(id);
  }
  if (!target) return;
  for (let part = target; part; part = part.parentElement) if (part.matches('details')) part.open = true;
  target.scrollIntoView();
};
addEventListener('hashchange', reveal);
reveal();
