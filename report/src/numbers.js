// Numbers as people read them.
const raised = '⁰¹²³⁴⁵⁶⁷⁸⁹';
export const superscript = (n) => String(n).replace('-', '⁻').replace(/\d/g, (d) => raised[d]);

export function spoken(value, digits = 4) {
  if (value == null || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) {
    const [mantissa, power] = value.toExponential(digits - 1).split('e');
    return `${parseFloat(mantissa)}·10${superscript(parseInt(power, 10))}`.replace('-', '−');
  }
  return String(parseFloat(value.toPrecision(digits))).replace('-', '−');
}

// A tick of a log axis; only powers of ten are written.
export function decade(value) {
  const power = Math.log10(value);
  if (Math.abs(power - Math.round(power)) > 1e-9) return '';
  return Math.abs(power) < 3.5 ? String(parseFloat(value.toPrecision(1))) : `10${superscript(Math.round(power))}`;
}
