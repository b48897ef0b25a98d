// A study as one page that needs no other file: settings to use, plots, pictures, every run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "octree/base/error_scale.h"
#include "scene/page/html_page.h"
#include "scene/study/study_table.h"
#include "sensor/picture/preview.h"
#include "sensor/picture/whole_file_io.h"

namespace obscura {

using namespace detail;

namespace {

const StudyRun& run_at(const Study& study, int index) { return study.runs[static_cast<std::size_t>(index)]; }

std::string with_sign(std::string text) {
  if (const auto at = text.find("+-"); at != std::string::npos) text.replace(at, 2, "&plusmn;");
  if (const auto at = text.find("< "); at != std::string::npos) text.replace(at, 2, "&lt; ");
  return text;
}

std::string per_cent(const RootError& error) { return with_sign(percent_text(error)); }

std::string cell(const std::string& html) { return "<td>" + html + "</td>"; }
std::string words(const std::string& text) { return "<td class=\"words\">" + html_escaped(text) + "</td>"; }

std::string settings_table(const Study& study) {
  std::string html = fmt::format(
      "<h2>Settings to use</h2>\n<div class=\"scroll\"><table><tr><th>error</th><th style=\"text-align:left\">cheapest "
      "setting that was measured to reach it"
      "</th><th>measured error</th><th>CPU, {0} x {1}</th><th>wall</th><th>memory</th><th>CPU, {2} x {3}</th></tr>\n",
      study.full_resolution[0], study.full_resolution[1], study.resolution[0], study.resolution[1]);
  const auto row = [&](const std::string& name, const StudyRun& run) {
    html += "<tr>" + cell(name) + words(study_label(run.setting)) + cell(per_cent(run.error.error)) +
            cell(seconds_text(run.full.cpu())) + cell(seconds_text(run.full.wall())) +
            cell(memory_text(run.full_bytes.total())) + cell(seconds_text(run.seconds.cpu())) + "</tr>\n";
  };
  bool told = false;
  for (const StudyTarget& target : study.targets) {
    if (target.run >= 0) {
      row(target_text(target.error), run_at(study, target.run));
    } else {
      html +=
          fmt::format("<tr><td>{}</td><td class=\"words\" colspan=\"6\"><span class=\"differ\">{}</span></td></tr>\n",
                      target_text(target.error), told ? "not reached" : html_escaped(not_reached_text(study)));
      told = true;
    }
  }
  if (study.as_given >= 0) row("as the scene says", run_at(study, study.as_given));
  html += fmt::format(
      "</table></div>\n<p class=\"about\">An error is reached where the measured one and its standard error together "
      "are below it. Times and memory of the "
      "{} x {} picture are predicted: World and photon map as they are, the image times {:.4g} for its pixels. All are "
      "for {} thread{} of this machine.</p>\n",
      study.full_resolution[0], study.full_resolution[1], study.pixel_ratio(), study.threads,
      study.threads == 1 ? "" : "s");
  html += "<details><summary>As options of <code>obscura render</code></summary>\n<ul class=\"what\">\n";
  for (const StudyTarget& target : study.targets) {
    if (target.run >= 0)
      html += fmt::format("<li>{}: <code>{}</code></li>\n", target_text(target.error),
                          html_escaped(command_text(study, run_at(study, target.run))));
  }
  return html + "</ul></details>\n";
}

/// What reached each error, method by method: CPU seconds of the whole picture.
std::string method_table(const Study& study) {
  std::string html = "<div class=\"scroll\"><table><tr><th>CPU to reach</th>";
  std::vector<const MethodType*> ran;
  for (const MethodType* method : methods()) {
    if (std::any_of(study.runs.begin(), study.runs.end(),
                    [&](const StudyRun& r) { return r.setting.method.type == method; }))
      ran.push_back(method);
  }
  for (const MethodType* method : ran) html += fmt::format("<th>{}</th>", method->name);
  html += "</tr>\n";
  for (const StudyTarget& target : study.targets) {
    html += "<tr>" + cell(target_text(target.error));
    for (const MethodType* method : ran) {
      const int run = target.per_method[index_of(*method)];
      html += run >= 0 ? fmt::format("<td{}>{}</td>", run == target.run ? " class=\"agree\"" : "",
                                     seconds_text(run_at(study, run).full.cpu()))
                       : std::string("<td class=\"faint\">not reached</td>");
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string slope_table(const Study& study) {
  if (study.slopes.empty()) return {};
  std::string html =
      "<div class=\"scroll\"><table><tr><th>along the ladder</th><th>of</th><th>exponent of the CPU time of map and "
      "image</th><th>points</th></tr>\n";
  for (const StudySlope& slope : study.slopes) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.2f} &plusmn; {:.2f}</td><td>{}</td></tr>\n",
                        slope.method->name, slope.what, slope.law.exponent, slope.law.exponent_error, slope.law.points);
  }
  return html + "</table></div>\n";
}

std::string knob_value(const std::string& knob, const StudySetting& s) {
  if (knob == "nearest") return std::to_string(s.method.nearest);
  if (knob == "kernel") return name_of(s.method.kernel);
  if (knob == "rays") return std::to_string(s.rays);
  if (knob == "photons") return std::to_string(s.method.photons);
  if (knob == "order") return fmt::format("S{}", s.method.order);
  if (knob == "octree_tolerance") return fmt::format("{:.3g}", s.octree_tolerance);
  return s.intervals > 0 ? std::to_string(s.intervals) : std::string("the scene's");
}

std::string knob_table(const Study& study) {
  std::vector<int> bases;
  for (const StudyRun& run : study.runs) {
    if (run.base >= 0 && std::find(bases.begin(), bases.end(), run.base) == bases.end()) bases.push_back(run.base);
  }
  if (bases.empty()) return {};
  std::string html =
      "<h2>Other knobs, each changed alone</h2>\n<div "
      "class=\"scroll\"><table><tr><th>knob</th><th>changed</th><th>error</th><th>bias</th><th>noise</th>"
      "<th>CPU, times</th><th>memory, times</th></tr>\n";
  for (const int number : bases) {
    const StudyRun& base = run_at(study, number);
    html += fmt::format("<tr><th colspan=\"2\">{}</th><td>{}</td><td>{}</td><td>{}</td><td></td><td></td></tr>\n",
                        html_escaped(study_label(base.setting)), per_cent(base.error.error), per_cent(base.error.bias),
                        per_cent(base.error.noise));
    for (const StudyRun& run : study.runs) {
      if (run.base != number) continue;
      html += fmt::format(
          "<tr><td>{}</td><td>{} &rarr; {}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.2f}</td></tr>\n",
          html_escaped(run.purpose), knob_value(run.purpose, base.setting), knob_value(run.purpose, run.setting),
          per_cent(run.error.error), per_cent(run.error.bias), per_cent(run.error.noise),
          run.full.cpu() / base.full.cpu(), run.full_bytes.total() / base.full_bytes.total());
    }
  }
  return html + "</table></div>\n";
}

/// 1, 2 or 5 times a power of ten, the next above.
double round_above(double value) {
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double m : {1.0, 2.0, 5.0}) {
    if (m * decade >= value) return m * decade;
  }
  return 10 * decade;
}

float percentile(std::vector<float> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string figure(const Study& study, const std::string& title, const std::string& channel,
                   const std::vector<float>& values, const PreviewSettings& settings) {
  Image image(study.resolution[0], study.resolution[1]);
  const std::span<float> plane = image.add(channel);
  std::copy(values.begin(), values.end(), plane.begin());
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                     html_picture(title, preview(image, channel, settings)), html_escaped(title));
}

/// Runs whose pictures are shown: what reached each target, else each method's best.
std::vector<int> chosen(const Study& study) {
  std::vector<int> runs;
  const auto add = [&](int run) {
    if (run >= 0 && std::find(runs.begin(), runs.end(), run) == runs.end()) runs.push_back(run);
  };
  for (const StudyTarget& target : study.targets) add(target.run);
  for (const MethodType* method : methods()) {
    int best = -1;
    for (std::size_t r = 0; r < study.runs.size(); ++r) {
      const int run = static_cast<int>(r);
      if (study.runs[r].setting.method.type == method &&
          (best < 0 || study.runs[r].error.error.value() < run_at(study, best).error.error.value()))
        best = run;
    }
    add(best);
  }
  return runs;
}

std::string pictures(const Study& study) {
  const Picture& reference = study.reference.picture.values();
  const Picture errors = study.reference.picture.errors();
  std::string html =
      "<h2>Pictures</h2>\n<p class=\"about\">Radiance in one scale; differences from the reference in per cent of the "
      "radiance, or of 5 % of its largest "
      "where that is more: blue is less, red is more. A difference holds the reference's own noise too.</p>\n";
  for (std::size_t b = 0; b < study.bands.size(); ++b) {
    if (study.bands.size() > 1) html += fmt::format("<h3>{}</h3>\n", html_escaped(study.bands[b]));
    const std::vector<float>& truth = reference.bands[b];
    float largest = 0;
    for (const float v : truth) largest = std::max(largest, std::abs(v));
    const auto relative = [&](const std::vector<float>& values, bool difference) {
      std::vector<float> result(values.size());
      for (std::size_t p = 0; p < values.size(); ++p) {
        const auto scale = static_cast<float>(error_scale(truth[p], largest));
        result[p] = scale > 0 ? 100 * (values[p] - (difference ? truth[p] : 0)) / scale : 0.0f;
      }
      return result;
    };
    PreviewSettings settings;
    settings.magnify = std::clamp(320 / std::max(study.resolution[0], study.resolution[1]), 1, 16);
    settings.colours = ColourMap::inferno;
    settings.low = percentile(truth, 0.002);
    settings.high = percentile(truth, 0.998);
    if (!(*settings.high > *settings.low))
      settings.high = *settings.low + std::max(1e-6, std::abs(*settings.low) * 0.01);
    PreviewSettings off = settings;
    off.colours = ColourMap::balance;
    const std::string unit = study.grey[b] ? "radiance" : "radiance [W/m2/sr]";

    const std::vector<int> runs = chosen(study);
    std::vector<std::vector<float>> differences;
    for (const int r : runs) differences.push_back(relative(run_at(study, r).pictures.front().bands[b], true));
    html += "<div class=\"pictures\">\n" + figure(study, "reference: " + study.reference.method, unit, truth, settings);
    PreviewSettings noise = off;
    noise.colours = ColourMap::viridis;
    noise.low = 0;
    const std::vector<float> own = relative(errors.bands[b], false);
    noise.high = std::max(percentile(own, 0.99), 1e-4f);
    html += figure(study, "its own standard error, per cent", "error [%]", own, noise) + "</div>\n";
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const StudyRun& run = run_at(study, runs[k]);
      std::vector<float> size = differences[k];
      for (float& v : size) v = std::abs(v);
      off.high = round_above(std::max(percentile(size, 0.98), 1e-3f));
      off.low = -*off.high;
      const std::string name = study_label(run.setting);
      html += "<div class=\"pictures\">\n" + figure(study, name, unit, run.pictures.front().bands[b], settings) +
              figure(study, fmt::format("its difference: {}", percent_text(run.error.error)), "difference [%]",
                     differences[k], off) +
              "</div>\n";
    }
  }
  return html;
}

std::string run_table(const Study& study) {
  std::string html = fmt::format(
      "<h2>Every setting that was measured</h2>\n<div "
      "class=\"scroll\"><table><tr><th>setting</th><th>why</th><th>error</th><th>bias</th><th>noise</th>"
      "<th>World</th><th>map</th><th>image</th><th>CPU</th><th>wall</th><th>CPU, {} x "
      "{}</th><th>memory</th><th>process so far</th></tr>\n",
      study.full_resolution[0], study.full_resolution[1]);
  for (const StudyRun& run : study.runs) {
    const StudySeconds& s = run.seconds;
    html += "<tr>" + cell(html_escaped(study_label(run.setting))) + cell(html_escaped(run.purpose)) +
            cell(per_cent(run.error.error)) + cell(per_cent(run.error.bias)) + cell(per_cent(run.error.noise)) +
            cell(seconds_text(s.world.cpu)) + cell(seconds_text(s.map.cpu)) + cell(seconds_text(s.image.cpu)) +
            cell(seconds_text(s.cpu())) + cell(seconds_text(s.wall())) + cell(seconds_text(run.full.cpu())) +
            cell(memory_text(run.bytes.total())) + fmt::format("<td>{:.0f} MiB</td></tr>\n", run.peak_MiB);
  }
  return html + "</table></div>\n";
}

std::string page(const Study& study) {
  std::string html = fmt::format(
      "<h1>Obscura {}: what accuracy costs</h1>\n<p class=\"about\">{}; {} x {} pixels for {} x {}; {} setting{} in "
      "{:.0f} s of a budget of {:.0f} s{}</p>\n",
      OBSCURA_VERSION, html_escaped(study.scene.empty() ? "scene " + study.hash : study.scene), study.resolution[0],
      study.resolution[1], study.full_resolution[0], study.full_resolution[1], study.runs.size(),
      study.runs.size() == 1 ? "" : "s", study.spent_s, study.budget_s,
      study.partial ? "; <span class=\"differ\">stopped before the end</span>" : "");
  html += fmt::format("<p class=\"about\">Reference: {}.</p>\n", html_escaped(reference_text(study)));
  if (study.reference.picture.known() && !study.runs.empty()) {
    html += settings_table(study);
    html += "<h2>Error against time and memory</h2>\n" + method_table(study);
    html += "<div class=\"plots\">\n" + time_plot(study).svg() + memory_plot(study).svg() + "</div>\n";
    html +=
        "<p class=\"about\">Filled: the ladder of each method, factors of four in its main cost. Hollow: other knobs, "
        "the scene's own setting, settings between rungs. Bars are standard "
        "errors, by a jackknife over tiles of pixels. Shaded: errors below the reference's own, which only its known "
        "variance lets one measure.</p>\n";
    html += "<h2>Bias and noise apart</h2>\n<div class=\"plots\">\n";
    for (const MethodType* method : methods()) {
      const auto rungs = std::count_if(study.runs.begin(), study.runs.end(), [&](const StudyRun& r) {
        return r.setting.method.type == method && r.purpose == kLadder;
      });
      if (rungs > 1) html += parts_plot(study, method).svg();
    }
    html += "</div>\n<p class=\"about\">Hollow: not to be told from none; what is drawn is how large it may be.</p>\n" +
            slope_table(study);
    html += knob_table(study) + pictures(study) + run_table(study);
  } else {
    html += "<p class=\"differ\">The study was stopped before its reference had an error: nothing can be said.</p>\n";
  }
  if (!study.refusals.empty() || !study.left_out.empty() || !study.warnings.empty()) {
    html += "<h2>Left out</h2>\n<ul class=\"what\">\n";
    for (const auto& [method, why] : study.refusals)
      html += fmt::format("<li>without {}: {}</li>\n", method->name, html_escaped(why));
    for (const std::string& text : study.left_out) html += fmt::format("<li>{}</li>\n", html_escaped(text));
    for (const std::string& text : study.warnings) html += fmt::format("<li>{}</li>\n", html_escaped(text));
    html += "</ul>\n";
  }
  html +=
      "<h2>How it was measured</h2>\n<p class=\"about\">The error is the RMS over pixels of (L &minus; L_ref) / "
      "max(|L_ref|, 5 % of the largest |L_ref|), of the band where it is "
      "largest; the reference's variance is taken off its square. Every setting makes two pictures a and b with random "
      "numbers of their own: noise&sup2; is the mean of "
      "(a &minus; b)&sup2; / 2, bias&sup2; that of (a &minus; ref)(b &minus; ref) less the reference's variance. CPU "
      "is that of all threads; every time holds the making of World and photon map. "
      "Memory is that of octrees, photon map (ordinates: the solver's vectors, by estimate) and film; &ldquo;process "
      "so far&rdquo; is the largest resident size of the whole study up to there, the "
      "reference's World among it. Pixels of the small picture cover more of the scene than those of the whole one: an "
      "error at full resolution may differ.</p>\n";
  return html_page("Obscura: what accuracy costs", html);
}

}  // namespace

void write_study_html(const std::filesystem::path& file, const Study& study) {
  write_whole_stream(file, [&](std::ostream& stream) { stream << page(study); });
}

}  // namespace obscura
