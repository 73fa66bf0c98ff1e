'use strict';
// Sorting: the header of a column becomes a button; empty cells stay last either way.
for (const table of document.querySelectorAll('table.sortable, table.checks')) {
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
// A link into a folded part unfolds it.
const reveal = () => {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  for (let part = target; part; part = part.parentElement) if (part.matches('details')) part.open = true;
  target.scrollIntoView();
};
addEventListener('hashchange', reveal);
reveal();
