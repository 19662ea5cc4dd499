// What every page can do: tables that sort, data that is read when it is asked for, and an address whose
// fragment asks for things (#sort=1.2&pair=3), so that what one person sees can be sent to another.
'use strict';
const diffsacPage = (() => {
  const wishes = new Map(location.hash.slice(1).split('&').filter((wish) => wish.includes('=')).map((wish) => {
    const at = wish.indexOf('=');
    return [wish.slice(0, at), decodeURIComponent(wish.slice(at + 1))];
  }));

  const json = (id) => {
    const element = document.getElementById(id);
    return element ? JSON.parse(element.textContent) : null;
  };

  const bytes = (id) => {
    const element = document.getElementById(id);
    if (!element) return null;
    const text = atob(element.textContent);
    const array = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) array[i] = text.charCodeAt(i);
    return array;
  };

  // Unknown values stay last in either direction.
  const compare = (a, b, direction) => {
    if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1;
    const order = typeof a === 'number' && typeof b === 'number' ? a - b
        : String(a).localeCompare(String(b), 'en', {numeric: true});
    return direction * order;
  };

  // Numbers begin with the largest, texts with a. Says the direction in which the column is sorted now.
  const nextDirection = (head, numeric) => {
    const now = head.getAttribute('aria-sort');
    return now === 'ascending' ? -1 : now === 'descending' ? 1 : numeric ? -1 : 1;
  };

  const mark = (head, direction) => {
    for (const other of head.parentElement.children) other.setAttribute('aria-sort', 'none');
    head.setAttribute('aria-sort', direction > 0 ? 'ascending' : 'descending');
  };

  const sort = (table, column, direction) => {
    const head = table.tHead.rows[0].cells[column];
    const numeric = head.classList.contains('number');
    const way = direction || nextDirection(head, numeric);
    const value = (row) => {
      const cell = row.cells[column];
      if (!numeric) return cell.textContent;
      return cell.dataset.value === undefined ? null : Number(cell.dataset.value);
    };
    for (const body of table.tBodies) {
      const rows = [...body.rows].map((row) => [value(row), row]);
      rows.sort((a, b) => compare(a[0], b[0], way));
      body.append(...rows.map((row) => row[1]));
    }
    mark(head, way);
  };

  const tables = [...document.querySelectorAll('table.sortable')];
  for (const table of tables) {
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      head.firstElementChild.addEventListener('click', () => sort(table, column));
    });
  }
  if (wishes.has('sort')) {
    const [table, column, way] = wishes.get('sort').split('.');
    const found = tables[Number(table) - 1];
    if (found && found.tHead.rows[0].cells[Number(column) - 1])
      sort(found, Number(column) - 1, way === 'asc' ? 1 : way === 'desc' ? -1 : 0);
  }
  return {wishes, json, bytes, compare, nextDirection, mark};
})();
