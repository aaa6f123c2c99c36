#include "src/diagnose/report.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include "src/base/whole_file.hpp"
#include "src/diagnose/equations.hpp"
#include "src/diagnose/report_words.hpp"
#include "src/diagnose/shown.hpp"
#include "src/output/axis_scale.hpp"
#include "src/output/page.hpp"
#include "src/output/pictures.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

using namespace page;

// A key of an effect in the units that it has here: those of instruments are in their channel's.
std::string unit_of_key(const std::string& key, const std::string& unit) {
  const Path path = split_path(key);
  if (path.size() == 3 && path[0] == "instrument" && (path[2] == "offset" || path[2] == "saturation")) return unit_of_channel(path[1]);
  return unit;
}

class Page {
 public:
  Page(const Experiment& experiment, const Diagnosis& d, ThreadTeam& team) : experiment_(experiment), d_(d), sides_(side_by_side(experiment, d, team)), runs_(telling_runs(experiment, d, sides_)) {
    misfits_ = misfit_by_run(experiment, sides_, team);
    before_ = d.train.before, after_ = d.train.after;
    const Comparison comparison(experiment, team);
    if (!sides_.one) {
      before_ = comparison.misfit(sides_.train_before, sides_.noise), after_ = comparison.misfit(sides_.train_after, sides_.noise);
      if (d.sealed) sealed_ = Before{comparison.misfit(sides_.sealed_before, sides_.noise), comparison.misfit(sides_.sealed_after, sides_.noise)};
    } else {
      sealed_ = d.sealed;
    }
  }

  std::string html() const {
    const std::string title = experiment_.base().has("title") ? experiment_.base().text("title") : experiment_.base().text("name");
    return page_of(title, look_for(d_.verdict), fmt::format("<h1>{}</h1>\n", e(title)) + verdict() + where() + what() + rivals() + better() + detectable() + method(), false);
  }

  const std::vector<RunChart>& runs() const { return runs_; }

 private:
  bool named() const { return d_.verdict == Verdict::omitted_physics; }

  std::string verdict() const {
    std::string text = fmt::format("<div class=\"verdict\"><strong>{}</strong>", e(sentence(d_)));
    if (!d_.indistinguishable.empty()) text += fmt::format("These recordings cannot tell it from {}.", e(joined(d_.indistinguishable, ", ", " or ")));
    std::string numbers;
    const auto number = [&](const std::string& value, const std::string& meaning) { numbers += fmt::format("<div><b>{}</b><span>{}</span></div>", value, meaning); };
    number(percent(d_.confidence), "confidence in this verdict");
    if (sides_.one) {
      number(ratio(after_), "misfit over noise");
      if (sealed_) number(ratio(sealed_->after), "on sealed recordings");
    } else {
      number(ratio(before_) + " → " + ratio(after_), "misfit over noise");
      if (sealed_) number(ratio(sealed_->before) + " → " + ratio(sealed_->after), "on sealed recordings");
    }
    if (sealed_ && (named() || d_.verdict == Verdict::unexplained))
      if (const double excess = sealed_->before * sealed_->before - 1; excess > 0.02)
        number(percent(std::max(0.0, 1 - std::max(0.0, sealed_->after * sealed_->after - 1) / excess)), "of the excess error there is gone");
    text += fmt::format("<div class=\"numbers\">{}</div></div>\n", numbers);
    std::vector<std::string> remarks = d_.remarks;
    remarks.insert(remarks.end(), experiment_.recording().remarks.begin(), experiment_.recording().remarks.end());
    if (!remarks.empty()) {
      text += "<ul>";
      for (const std::string& one : remarks) text += fmt::format("<li>{}</li>", e(capital(with_words(one))));
      text += "</ul>\n";
    }
    return text;
  }

  // Names of effects within a sentence, as words.
  static std::string with_words(const std::string& sentence) {
    std::string text = sentence;
    std::vector<std::string> names = {"camera_distortion"};
    for (const EffectEntry& entry : all_effects()) names.emplace_back(entry.name);
    for (const std::string& name : names) {
      if (name.find('_') == name.npos) continue;
      for (auto at = text.find(name); at != text.npos; at = text.find(name, at)) text.replace(at, name.size(), words_of(name));
    }
    return text;
  }

  std::string where() const {
    std::string text = "<h2>Where</h2>\n";
    const Location& w = d_.where;
    if (!w.channel.empty()) {
      // Instants that only rounding parts from zero.
      const auto clean = [&](double t) { return std::abs(t) < 1e-9 * (w.to - w.from) ? 0.0 : t; };
      const std::string channel = w.channel == "impact" ? "the instants of impact" : code(w.channel);
      std::string at = w.variable == "impact" ? fmt::format("from impact {:.0f} to {:.0f}", w.from, w.to) : fmt::format("from t = {} to {} {}", brief(clean(w.from), 3), brief(clean(w.to), 3), e(spoken_unit(w.unit)));
      if (!w.phase.empty()) at += w.phase == "flight" ? ", in flight" : w.phase == "after contact" ? ", after the contact" : ", while " + w.phase;
      at += w.run.empty() ? ", not in one run alone" : fmt::format(", in run {}", e(w.run));
      text += paragraph(fmt::format("In {}, {}: nine tenths of what the better simulation changes lie there. The recording lies mostly {} the calibrated case. Probability that "
                                    "noise alone does as much: {}.", channel, at, e(w.sign), chance(w.p_value)));
    } else if (d_.verdict == Verdict::nothing_missing || d_.verdict == Verdict::parameters_only) {
      text += paragraph(fmt::format("Nowhere{}. Of all the shapes looked for in what is left, the strongest is one that noise makes too (probability {}).",
                                    d_.verdict == Verdict::parameters_only ? ", once it is calibrated" : "", chance(d_.adequacy_p)));
    } else if (d_.verdict == Verdict::unexplained) {
      text += paragraph(fmt::format("Something is left that is not noise (probability {}); no better simulation was found that would tell where.", chance(d_.adequacy_p)));
    } else if (!runs_.empty()) {
      text += paragraph("Whether they differ beyond noise was not to be told.");
    }
    if (runs_.empty()) return text;
    if (!sides_.one)
      text += fmt::format("<p class=\"note\">Orange: {}. Blue: {}{}.</p>\n", e(sides_.before_name), e(sides_.after_name),
                          runs_.front().run.empty() ? "" : "; in the middle, what it adds, through the residuals before");
    text += fmt::format("<div class=\"runs{}\">\n", runs_.size() == 1 ? " one" : "");
    for (const RunChart& run : runs_)
      text += captioned_figure_of(run.chart, fmt::format("<b>{}</b>, {}{}", run.run.empty() ? "All runs" : "Run " + e(run.run), e(run.why), run.cut.empty() ? "" : ". " + e(run.cut)));
    return text + "</div>\n";
  }

  std::string what() const {
    std::string text;
    if (named()) {
      text += "<h2>What</h2>\n";
      for (std::size_t k = 0; k < d_.effects.size(); ++k) {
        const std::string& name = d_.effects[k];
        std::vector<std::string> keys;
        for (const Estimate& one : d_.parameters)
          if (one.of_effect) keys.push_back(one.key);
        EffectEquation equation = equation_of(name, keys);
        if (equation.equation.empty()) equation = equation_of(name);
        const EffectEntry* entry = find_effect(name);
        text += paragraph(fmt::format("<b>{}</b>{}", e(words_of(name)), k == 0 && !d_.form.empty() ? ": " + e(d_.form) : ""));
        if (!equation.equation.empty()) text += fmt::format("<p class=\"equation\">{}</p><p class=\"note\">{}</p>\n", e(equation.equation), e(equation.where));
        if (entry != nullptr) text += paragraph(fmt::format("How it shows: {}.{}", e(entry->signature), entry->source[0] ? fmt::format(" <span class=\"note\">({})</span>", e(entry->source)) : ""));
      }
    } else if (d_.verdict == Verdict::unexplained) {
      text += "<h2>What</h2>\n";
      if (const std::optional<Chart> curve = learnt_force(d_)) {
        text += paragraph(fmt::format("The force that is missing, learnt from the recordings: {}. It is a description, not an explanation; <code>amended.toml</code> carries it as a tabulated force.", e(d_.signature)));
        text += "<div class=\"runs one\">" + captioned_figure_of(*curve, "<b>Learnt force</b> and its 95 % band, straight between the points, level beyond") + "</div>\n";
      } else {
        text += paragraph("No single force as a function of the state that was tried does better than the calibrated case.");
      }
    }
    return text + parameters();
  }

  std::string parameters() const {
    std::string rows;
    std::set<Path> told;
    for (const Estimate& one : d_.parameters) {
      if (one.key.ends_with("]")) continue;  // knots of a curve
      const Path path = path_of(one.key);
      const Key* key = find_key(path);
      const std::string unit = unit_of_key(one.key, one.unit);
      std::string was = "–";
      if (one.nominal) was = with_unit(brief(*one.nominal), unit);
      else if (one.of_effect) was = "not there";
      const Spoken spoken = spoken_of(one);
      rows += fmt::format("<tr{}><td>{}<span class=\"note\">{}</span></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", one.of_effect ? " class=\"chosen\"" : "", code(one.key),
                          key != nullptr && told.insert(path).second ? e(key->meaning) : "", e(with_unit(spoken.value, unit)), spoken.interval, e(was));
    }
    if (rows.empty()) return "";
    const std::string head = named() || d_.verdict == Verdict::unexplained ? "" : "<h2>What was calibrated</h2>\n";
    return fmt::format("{}<div class=\"wide\"><table><tr><th>key of the case</th><th class=\"n\">value</th><th class=\"n\">95 % interval</th><th class=\"n\">the case</th></tr>\n{}</table></div>\n", head, rows);
  }

  // Without the component of a vector, and without the body that a number is of.
  static Path path_of(const std::string& key) {
    Path path = split_path(key.substr(0, key.find('@')));
    if (find_key(path) == nullptr && path.size() > 1) path.pop_back();
    return path;
  }

  std::string rivals() const {
    if (d_.ranking.empty()) return "";
    std::string text = fmt::format("<h2>{}</h2>\n", named() ? "Why this and not that" : "What was tried");
    std::string rows;
    double sum = 0;
    for (const Tried& t : d_.ranking) sum += t.probability;
    bool base_shown = false;
    const double base_probability = std::max(0.0, 1 - sum);
    const auto base = [&] {
      base_shown = true;
      rows += fmt::format("<tr><td>nothing more</td><td>the calibrated case</td><td class=\"n\">{}</td><td class=\"n\">0</td><td class=\"n\">–</td></tr>\n", percent(base_probability));
    };
    std::size_t shown = 0;
    constexpr std::size_t most = 12;
    for (const Tried& t : d_.ranking) {
      if (!base_shown && base_probability >= t.probability) base();
      if (++shown > most) continue;
      const bool chosen = named() && t.effects == d_.effects && t.candidate.form == d_.form;
      std::string form = t.candidate.free_form ? "a learnt force " + t.candidate.form : t.candidate.form;
      if (t.candidate.rival) form += fmt::format("{}no effect; held against it", form.empty() ? "" : "; ");
      rows += fmt::format("<tr{}><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", chosen ? " class=\"chosen\"" : "",
                          t.candidate.free_form ? "unknown" : e(joined(t.effects, " + ", " + ")), form.empty() ? "–" : e(form), percent(t.probability), brief(t.bic, std::abs(t.bic) < 1e4 ? 4 : 3),
                          t.held_out > 0 ? ratio(t.held_out) : "–");
    }
    if (!base_shown) base();
    text += fmt::format("<div class=\"wide\"><table><tr><th>effect</th><th>form</th><th class=\"n\">probability</th><th class=\"n\">BIC difference</th><th class=\"n\">held-out<br>misfit</th></tr>\n{}</table></div>\n", rows);
    if (d_.ranking.size() > most) text += fmt::format("<p class=\"note\">{} less probable ones are in <code>diagnosis.json</code>.</p>\n", d_.ranking.size() - most);
    text += "<p class=\"note\">Each was fitted with every free number of the case fitted again. BIC difference: to the calibrated case; below zero is better, by more than its further numbers cost. Held-out misfit: "
            "RMS of residual over noise on runs that this fit did not see.</p>\n";
    if (!d_.indistinguishable.empty()) text += paragraph(fmt::format("<b>Look-alikes</b>, with a probability within a factor of twenty of the verdict's: {}.", e(joined(d_.indistinguishable))));
    if (!d_.advice.empty()) text += paragraph(fmt::format("<b>What would settle it.</b> {}", e(with_words(d_.advice))));
    else if (named())
      if (const EffectEntry* entry = find_effect(d_.effects.front())) text += paragraph(fmt::format("<b>What would test it.</b> {}.", e(capital(entry->experiment))));
    return text;
  }

  std::string better() const {
    if (misfits_.empty() || !std::isfinite(after_)) return "";
    std::string text = fmt::format("<h2>{}</h2>\n", sides_.one ? "How well it fits, run by run" : "How much better, and on what it has not seen");
    if (sealed_) {
      if (!sides_.one) {
        text += paragraph(fmt::format("{} sealed {} took no part in fitting or choosing. There the misfit goes from {} to {} times the noise ({}; {}).", d_.sealed_runs.size(), d_.sealed_runs.size() == 1 ? "run" : "runs", ratio(sealed_->before),
                                      ratio(sealed_->after), e(sides_.before_name), e(sides_.after_name)));
      }
    } else {
      text += paragraph("No runs were sealed: with fewer than four there are none to spare. What is shown was fitted.");
    }
    std::vector<RunMisfit> order = misfits_;
    std::erase_if(order, [](const RunMisfit& one) { return !std::isfinite(one.before) || !std::isfinite(one.after); });
    constexpr std::size_t most = 40;
    const bool all = order.size() <= most;
    if (!all) {
      std::stable_sort(order.begin(), order.end(), [](const RunMisfit& a, const RunMisfit& b) { return a.before > b.before; });
      order.resize(most);
    }
    std::vector<BeforeAfter> rows;
    bool any_sealed = false;
    for (const bool sealed : {false, true})
      for (const RunMisfit& one : order)
        if (one.sealed == sealed) rows.push_back({one.run.size() > 24 ? one.run.substr(0, 23) + "…" : one.run, one.before, one.after, sealed}), any_sealed |= sealed;
    text += fmt::format("<div class=\"runs one\"><figure><figcaption>{}{}{}</figcaption>{}</figure></div>\n", sides_.one ? "Dot: misfit of each run" : fmt::format("Ring: {}. Dot: {}", e(sides_.before_name), e(sides_.after_name)),
                        any_sealed ? ". Orange: sealed" : "", all ? "" : fmt::format(". The {} of {} runs that fitted worst before", most, misfits_.size()),
                        svg_of(rows, "RMS of residual over noise; 1: nothing but noise", 1));
    return text;
  }

  std::string detectable() const {
    std::string rows;
    std::vector<std::string> hidden;
    std::vector<Detectable> all = d_.detectable;
    std::sort(all.begin(), all.end(), [](const Detectable& a, const Detectable& b) { return a.effect < b.effect; });
    for (const Detectable& one : all) {
      const Key* key = find_key(split_path(one.key));
      if (!std::isfinite(one.strength) || one.strength > 1e9 || (key != nullptr && one.strength > key->range.most)) {
        hidden.push_back(one.effect);
        continue;
      }
      rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td></tr>\n", e(words_of(one.effect)), code(one.key), e(with_unit(brief(one.strength, 2), unit_of_key(one.key, one.unit))));
    }
    if (rows.empty()) return "";
    return "<h2>What could have been seen</h2>\n" +
           paragraph("The least change of each key, from where it does nothing, that these recordings would have shown in four of five cases, beside everything that is calibrated. Weaker effects may be there.") +
           fmt::format("<div class=\"wide\"><table><tr><th>effect</th><th>key</th><th class=\"n\">least change</th></tr>\n{}</table></div>\n", rows) +
           (hidden.empty() ? "" : paragraph(fmt::format("At no strength: {}.", e(joined(hidden)))));
  }

  std::string method() const {
    std::string text = "<h2>How it was compared</h2>\n";
    const auto runs = [](const std::vector<std::string>& labels) {
      if (labels.empty()) return std::string("none");
      constexpr std::size_t most = 12;
      std::string list;
      for (std::size_t k = 0; k < std::min(most, labels.size()); ++k) list += (k ? ", " : "") + labels[k];
      return fmt::format("{}{}", e(list), labels.size() > most ? fmt::format(" and {} more", labels.size() - most) : "");
    };
    text += fmt::format("<ul>{}<li>Runs fitted: {}.</li><li>Runs for choosing: {}.</li><li>Runs sealed to the end: {}.</li>", d_.baseline.moved.empty() ? "<li>The case frees no number to be calibrated.</li>" : "", runs(d_.fit_runs), runs(d_.select_runs), runs(d_.sealed_runs));
    // Too few samples: neither was asked.
    const bool asked = d_.verdict != Verdict::insufficient_data || !d_.detectable.empty();
    if (asked) {
      text += fmt::format("<li>Whether noise explains what is left: p = {} with the calibrated case{}.</li>", chance(d_.adequacy_p), named() ? fmt::format(", {} with what was found", chance(d_.remaining_p)) : "");
      text += fmt::format("<li>Time step {} or longer; half of it moves all samples together by {} standard deviations of the noise.</li>", e(with_unit(brief(d_.steps.shortest(), 3), "s")), brief(d_.numerical_error, 2));
    }
    text += "</ul>\n";
    std::string rows;
    std::set<Channel> channels;
    bool recorded_deviations = false;
    for (const RecordedRun& run : experiment_.recording().runs)
      for (const Series& series : run.series) channels.insert(series.channel), recorded_deviations |= !series.deviation.empty();
    for (const Channel channel : channels) {
      const ChannelNoise& noise = d_.best.noise[static_cast<std::size_t>(channel)];
      // What the clock trembles, where that shows.
      const double tremble = noise.jitter * noise.deviation;
      rows += fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", code(name_of(channel)),
                          e(recorded_deviations ? brief(noise.deviation, 3) + " × recorded" : with_unit(brief(noise.deviation, 3), unit_of(channel))), noise.correlation > 0 ? percent(noise.white) : "100 %",
                          noise.correlation > 0 ? brief(noise.correlation, 2) : "–", tremble > 0 && !recorded_deviations ? brief(tremble, 2) + " s" : "–", noise.tail > 1e6 ? "normal" : fmt::format("t, ν = {}", brief(noise.tail, 2)));
    }
    text += fmt::format("<div class=\"wide\"><table><tr><th>noise of</th><th class=\"n\">standard deviation</th><th class=\"n\">white part of<br>the variance</th><th class=\"n\">slow part: correlation<br>of neighbours</th>"
                        "<th class=\"n\">clock<br>trembles by</th><th class=\"n\">tails</th></tr>\n{}</table></div>\n", rows);
    std::vector<std::string> files;
    for (const std::string& file : experiment_.recording().files) files.push_back(code(file));
    text += paragraph(fmt::format("Case {}, {} {}. Beside this page: <code>diagnosis.json</code>, <code>amended.toml</code> (runs with <code>quern run</code>), <code>residuals.csv</code> (every sample), "
                                  "<code>fits.csv</code> (every fit), <code>diagnosis.png</code>.", code(experiment_.base().file), files.size() == 1 ? "recording" : "recordings", fmt::format("{}", fmt::join(files, ", "))));
    return text;
  }

  const Experiment& experiment_;
  const Diagnosis& d_;
  SideBySide sides_;
  std::vector<RunChart> runs_;
  std::vector<RunMisfit> misfits_;
  double before_ = 0, after_ = 0;
  std::optional<Before> sealed_;
};

}  // namespace

std::vector<std::string> write_report(const Experiment& given, const Diagnosis& d, ThreadTeam& team, const std::string& directory) {
  Experiment experiment = given;
  experiment.steps = d.steps;  // that the diagnosis came to
  const Page page(experiment, d, team);
  write_whole_file(directory + "/report.html", page.html());
  if (page.runs().empty()) return {};
  PictureRequest request;
  request.directory = directory;
  request.charts = {page.runs().front().chart};
  return draw_pictures(request).remarks;
}

}  // namespace quern
