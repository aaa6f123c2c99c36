// A table whose rows are sorted by the column that is chosen; once more: the other way round.
const keyOf = (row, column) => {
  const cell = row.cells[column];
  return cell.dataset.value ?? cell.textContent;
};

export function sortable(table) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener('click', () => {
      const down = head.getAttribute('aria-sort') === 'ascending';
      heads.forEach((other) => other.removeAttribute('aria-sort'));
      head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      const rows = [...body.rows];
      const order = (a, b) => {
        const [x, y] = [keyOf(a, column), keyOf(b, column)];
        if (x === '' || y === '') return (x === '') - (y === ''); // what is not known comes last
        const [p, q] = [Number(x), Number(y)];
        const before = Number.isNaN(p) || Number.isNaN(q) ? x.localeCompare(y) : p - q;
        return down ? -before : before;
      };
      body.append(...rows.sort(order));
    });
  });
}
