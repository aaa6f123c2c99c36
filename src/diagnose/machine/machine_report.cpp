#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/whole_file.hpp"
#include "src/diagnose/catalogue.hpp"
#include "src/diagnose/machine/machine_written.hpp"
#include "src/diagnose/report_words.hpp"
#include "src/output/page.hpp"
#include "src/output/pictures.hpp"

namespace quern {
namespace {

using namespace page;

// One channel: what was recorded, and the simulation before and after, against the leading condition or the energy.
Chart chart_of(const MachineExperiment& experiment, const MachineDiagnosis& d, std::size_t c, bool both) {
  const RecordedChannel& channel = experiment.channels()[c];
  struct Point {
    double at, recorded, noise, before, before_deviation, after, after_deviation;
  };
  std::vector<Point> points;
  const bool spectrum = channel.scale == Scale::logarithm;
  const std::string& leading = experiment.leading_condition();
  for (const MachineResidual& r : d.residuals) {
    if (r.channel != c) continue;
    const RecordedChannel::Site& site = channel.sites[r.site];
    const double at = spectrum ? site.energy : leading.empty() ? 0 : experiment.recording().rows[site.row].conditions.at(leading);
    points.push_back({at, r.recorded, r.noise, r.before, r.before_deviation, r.after, r.after_deviation});
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.at < b.at; });
  constexpr double of_interval = 1.96;
  const auto shown = [&](double y) { return channel.plain(y); };
  Curve recorded{"recorded", {}, {}, {}, {}, true, false}, before{both ? "the calibrated case" : "the simulation", {}, {}, {}, {}}, after{"with " + joined(d.effects), {}, {}, {}, {}};
  for (const Point& p : points) {
    const auto add = [&](Curve& curve, double y, double deviation) {
      curve.x.push_back(p.at), curve.y.push_back(shown(y));
      curve.lower.push_back(shown(y - of_interval * deviation)), curve.upper.push_back(shown(y + of_interval * deviation));
    };
    add(recorded, p.recorded, p.noise), add(before, p.before, p.before_deviation), add(after, p.after, p.after_deviation);
  }
  const std::string unit = spectrum ? "J" : unit_of_machine_condition(leading);
  Panel panel;
  panel.x_label = fmt::format("{}{}", words_of(spectrum ? "energy" : leading), unit == "1" ? "" : " [" + unit + "]");
  const std::string of = machine_channel(channel.name).unit;
  panel.y_label = fmt::format("{}{}", words_of(channel.label()), of == "1" ? "" : " [" + of + "]");
  panel.log_x = panel.log_y = spectrum;
  panel.curves = {recorded, before};
  if (both) panel.curves.push_back(after);
  return {"diagnosis.png", words_of(channel.label()), {panel}};
}

std::string verdict_of(const MachineExperiment& experiment, const MachineDiagnosis& d, bool both) {
  std::string text = fmt::format("<div class=\"verdict\"><strong>{}</strong>", e(sentence(d)));
  if (!d.indistinguishable.empty()) text += fmt::format("These recordings cannot tell it from {}.", e(joined(d.indistinguishable, ", ", " or ")));
  text += "<div class=\"numbers\">";
  const auto number = [&](const std::string& value, const std::string& meaning) { text += fmt::format("<div><b>{}</b><span>{}</span></div>", value, meaning); };
  number(percent(d.confidence), "confidence in this verdict");
  number(both ? ratio(d.train.before) + " → " + ratio(d.train.after) : ratio(d.train.after), "misfit over noise");
  if (d.sealed) number(both ? ratio(d.sealed->before) + " → " + ratio(d.sealed->after) : ratio(d.sealed->after), "under sealed conditions");
  text += "</div></div>\n";
  std::vector<std::string> remarks = d.remarks;
  remarks.insert(remarks.end(), experiment.remarks().begin(), experiment.remarks().end());
  if (remarks.empty()) return text;
  text += "<ul>";
  for (const std::string& one : remarks) text += fmt::format("<li>{}</li>", e(capital(one)));
  return text + "</ul>\n";
}

std::string where_of(const MachineDiagnosis& d) {
  const Location& w = d.where;
  if (w.channel.empty()) return "";
  const std::string at = w.variable.empty() ? "" : fmt::format(", {} from {} to {}", e(words_of(w.variable)), brief(w.from, 3), e(with_unit(brief(w.to, 3), w.unit)));
  return paragraph(fmt::format("Most of it in {}{}: the recording lies {} the calibrated case. Probability that noise alone does as much: {}.", code(w.channel), at, e(w.sign), chance(w.p_value)));
}

std::string parameters_of(const MachineDiagnosis& d) {
  std::string rows;
  for (const Estimate& one : d.parameters) {
    const Key* key = find_key(split_path(one.key));
    const Spoken spoken = spoken_of(one);
    rows += fmt::format("<tr{}><td>{}<span class=\"note\">{}</span></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", one.of_effect ? " class=\"chosen\"" : "", code(one.key),
                        key != nullptr ? e(key->meaning) : "", e(with_unit(spoken.value, one.unit)), spoken.interval, one.nominal ? e(with_unit(brief(*one.nominal), one.unit)) : "not there");
  }
  if (rows.empty()) return "";
  return fmt::format("<h2>What</h2>\n{}<div class=\"wide\"><table><tr><th>key</th><th class=\"n\">value</th><th class=\"n\">95 % interval</th><th class=\"n\">the case</th></tr>\n{}</table></div>\n",
                     d.signature.empty() ? "" : paragraph(fmt::format("How it shows: {}.", e(d.signature))), rows);
}

std::string rivals_of(const MachineDiagnosis& d) {
  if (d.ranking.empty()) return "";
  std::string rows;
  constexpr std::size_t most = 12;
  for (std::size_t k = 0; k < std::min(most, d.ranking.size()); ++k) {
    const Ranked& r = d.ranking[k];
    const bool chosen = d.verdict == Verdict::omitted_physics && r.effects == d.effects && r.form == d.form;
    rows += fmt::format("<tr{}><td>{}</td><td>{}{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", chosen ? " class=\"chosen\"" : "", e(joined(r.effects, " + ", " + ")), r.form.empty() ? "–" : e(r.form),
                        r.rival ? "; no effect, held against it" : "", percent(r.probability), brief(r.bic), r.held_out > 0 ? ratio(r.held_out) : "–");
  }
  std::string text = fmt::format("<h2>Why this and not that</h2>\n<div class=\"wide\"><table><tr><th>effect</th><th>form</th><th class=\"n\">probability</th><th class=\"n\">BIC difference</th><th class=\"n\">held-out<br>misfit</th></tr>\n{}</table></div>\n", rows);
  if (!d.advice.empty()) text += paragraph(fmt::format("<b>What would settle it.</b> {}", e(d.advice)));
  return text;
}

std::string detectable_of(const MachineDiagnosis& d) {
  std::string rows;
  for (const Detectable& one : d.detectable) rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td></tr>\n", e(words_of(one.effect)), code(one.key), e(with_unit(brief(one.strength, 2), one.unit)));
  if (rows.empty()) return "";
  return "<h2>What could have been seen</h2>\n" + paragraph("The least change of each key that these recordings would have shown in four of five cases, beside everything that is calibrated. Weaker effects may be there.") +
         fmt::format("<div class=\"wide\"><table><tr><th>effect</th><th>key</th><th class=\"n\">least change</th></tr>\n{}</table></div>\n", rows);
}

std::string method_of(const MachineExperiment& experiment, const MachineDiagnosis& d) {
  const auto labels = [](const std::vector<std::string>& all) { return all.empty() ? std::string("none") : e(fmt::format("{}", fmt::join(all, "; "))); };
  return fmt::format("<h2>How it was compared</h2>\n<ul><li>Conditions fitted: {}.</li><li>Conditions for choosing: {}.</li><li>Conditions sealed to the end: {}.</li><li>Whether noise, of the recording and of the simulation, explains what is left: "
                     "p = {} with the calibrated case{}.</li><li>{} simulations.</li></ul>\n", labels(d.fit_runs), labels(d.select_runs), labels(d.sealed_runs), chance(d.adequacy_p),
                     d.verdict == Verdict::omitted_physics ? fmt::format(", {} with what was found", chance(d.remaining_p)) : "", d.runs) +
         paragraph(fmt::format("Case {}. Beside this page: <code>diagnosis.json</code>, <code>amended.toml</code> (runs with <code>quern run</code>), <code>residuals.csv</code>, <code>fits.csv</code>, and every simulation in <code>runs</code>.", code(experiment.base().file)));
}

}  // namespace

std::vector<std::string> write_machine_report(const MachineExperiment& experiment, const MachineDiagnosis& d, const std::string& directory) {
  const bool both = d.verdict == Verdict::omitted_physics;
  const std::string title = experiment.base().has("title") ? experiment.base().text("title") : experiment.base().text("name");
  std::string charts;
  Chart picture{"diagnosis.png", title, {}};
  if (!d.residuals.empty())
    for (std::size_t c = 0; c < experiment.channels().size(); ++c) {
      const Chart chart = chart_of(experiment, d, c, both);
      charts += captioned_figure_of(chart, "");
      picture.panels.push_back(chart.panels.front());
    }
  const std::string body = fmt::format("<h1>{}</h1>\n{}<h2>Where</h2>\n{}<div class=\"runs\">\n{}</div>\n{}{}{}{}", e(title), verdict_of(experiment, d, both), where_of(d), charts, parameters_of(d), rivals_of(d), detectable_of(d),
                                       method_of(experiment, d));
  write_whole_file(directory + "/report.html", page_of(title, look_for(d.verdict), body, false));
  if (picture.panels.empty()) return {};
  PictureRequest request;
  request.directory = directory;
  request.charts = {picture};
  return draw_pictures(request).remarks;
}

}  // namespace quern
