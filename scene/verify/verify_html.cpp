// The verdict as one page that needs no other file: pictures side by side, their differences, the table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "octree/base/error_scale.h"
#include "scene/page/html_page.h"
#include "scene/verify/verify.h"
#include "sensor/picture/preview.h"
#include "sensor/picture/whole_file_io.h"

namespace obscura {

using namespace detail;

namespace {

std::string picture(const std::string& title, const VerifiedScene& scene, const std::vector<float>& values,
                    const PreviewSettings& settings) {
  Image image(scene.resolution[0], scene.resolution[1]);
  const std::span<float> channel = image.add(title);
  std::copy(values.begin(), values.end(), channel.begin());
  return html_picture(title, preview(image, title, settings));
}

double percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string pictures_of(const VerifiedScene& scene, std::size_t band) {
  std::vector<VerifyPicture> all(scene.methods.size());
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (!scene.methods[m].pictures.empty()) all[m] = scene.methods[m].pictures[band];
  }
  const std::string unit = scene.grey[band] ? "" : " [W/m2/sr]";
  PreviewSettings settings;
  settings.magnify = std::clamp(256 / std::max(scene.resolution[0], scene.resolution[1]), 1, 16);

  // One scale for all methods, and the same for their errors.
  std::vector<float> values, errors;
  for (const VerifyPicture& p : all) {
    values.insert(values.end(), p.radiance.begin(), p.radiance.end());
    errors.insert(errors.end(), p.error.begin(), p.error.end());
  }
  if (values.empty()) return {};
  const auto row = [](const std::string& content) { return "<div class=\"pictures\">\n" + content + "</div>\n"; };
  const auto each = [&](const auto& make) {
    std::string content;
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (!all[m].radiance.empty()) content += make(scene.methods[m].name, all[m]);
    }
    return row(content);
  };
  const auto pairs = [&](const auto& make) {
    std::string content;
    for (const VerifyPixels& p : scene.pixels) {
      if (p.band != scene.bands[band]) continue;
      content += make(fmt::format("{} - {}", scene.methods[p.first].name, scene.methods[p.second].name), all[p.first],
                      all[p.second]);
    }
    return row(content);
  };

  std::string html;
  settings.colours = ColourMap::inferno;
  settings.low = percentile(values, 0.002);
  settings.high = percentile(values, 0.998);
  html += each([&](const std::string& name, const VerifyPicture& p) {
    return picture(name + unit, scene, p.radiance, settings);
  });
  settings.colours = ColourMap::viridis;
  settings.low = 0;
  settings.high = std::max(percentile(errors, 0.998), 1e-30);
  html += each([&](const std::string& name, const VerifyPicture& p) {
    return picture(name + ": error", scene, p.error, settings);
  });

  settings.colours = ColourMap::balance;
  settings.low = -4;
  settings.high = 4;
  html += pairs([&](const std::string& name, const VerifyPicture& a, const VerifyPicture& b) {
    std::vector<float> z(a.radiance.size());
    for (std::size_t i = 0; i < z.size(); ++i) {
      const double difference = static_cast<double>(a.radiance[i]) - b.radiance[i],
                   error = std::hypot(a.error[i], b.error[i]);
      z[i] = error > 0 ? static_cast<float>(difference / error) : 0.0f;
    }
    return picture(name + ", in joint errors", scene, z, settings);
  });
  html += pairs([&](const std::string& name, const VerifyPicture& a, const VerifyPicture& b) {
    const float largest = *std::max_element(b.radiance.begin(), b.radiance.end());
    std::vector<float> relative(a.radiance.size()), size(a.radiance.size());
    for (std::size_t i = 0; i < relative.size(); ++i) {
      const auto floor = static_cast<float>(error_scale(b.radiance[i], largest));
      relative[i] = floor > 0 ? 100 * (a.radiance[i] - b.radiance[i]) / floor : 0.0f;
      size[i] = std::abs(relative[i]);
    }
    PreviewSettings percent = settings;
    percent.high = std::max(percentile(size, 0.99), 1e-3);
    percent.low = -*percent.high;
    return picture(name + ", per cent", scene, relative, percent);
  });
  return html;
}

std::string cell(const std::optional<Measured>& m) {
  if (!m) return "<td class=\"faint\">&ndash;</td>";
  return fmt::format("<td>{:.5g} &plusmn; {:.2g}</td>", m->value, m->error);
}

std::string table_of(const VerifiedScene& scene) {
  std::string html = "<div class=\"scroll\"><table><tr><th>quantity</th>";
  for (const std::string& word : method_words()) html += fmt::format("<th>{}</th>", word);
  html +=
      "<th>photon bias</th><th>pair</th><th>difference</th><th>z (limit)</th><th>would be "
      "seen</th><th>verdict</th></tr>\n";
  const auto verdict = [](bool good, const char* word) {
    return fmt::format("<td class=\"{}\">{}</td>", good ? "agree" : "differ", word);
  };
  for (const VerifyRow& row : scene.rows) {
    const std::string name = html_escaped(scene.bands.size() > 1 ? row.quantity + ", " + row.band : row.quantity);
    std::string values = fmt::format("<td>{}</td>", name);
    for (const auto& m : row.measured) values += cell(m);
    values += row.measured[0] ? fmt::format("<td>{:.2g}</td>", row.measured[0]->bias) : "<td></td>";
    if (row.pairs.empty()) html += "<tr>" + values + "<td></td><td></td><td></td><td></td><td></td></tr>\n";
    for (const VerifyPair& pair : row.pairs) {
      const Agreement& a = pair.agreement;
      const bool sharp = a.sharp || !scene.demands_resolution;
      html += fmt::format(
          "<tr>{}<td>{} &minus; {}</td><td>{:+.2f} %</td><td>{:+.1f} ({:.1f})</td><td>{:.1f} %</td>{}</tr>\n", values,
          scene.methods[pair.first].name, scene.methods[pair.second].name, 100 * a.relative, a.z, a.limit,
          100 * a.detectable,
          verdict(a.agree && sharp, !a.agree                   ? "differ"
                                    : a.sharp                  ? "agree"
                                    : scene.demands_resolution ? "too weak"
                                                               : "not judged"));
      values = "<td></td><td></td><td></td><td></td><td></td>";
    }
  }
  for (const VerifyPixels& p : scene.pixels) {
    const PixelAgreement& a = p.agreement;
    html += fmt::format(
        "<tr><td>{}</td><td></td><td></td><td></td><td></td><td>{} &minus; {}</td><td>{:.2f} % rms</td><td>{:.2f} "
        "({:.2f}) rms"
        "</td><td>{:.0f} % inside 95 %</td>{}</tr>\n",
        html_escaped(scene.bands.size() > 1 ? "pixels, " + p.band : "pixels"), scene.methods[p.first].name,
        scene.methods[p.second].name, 100 * a.image_error, a.rms_z, a.high, 100 * a.inside,
        verdict(a.agree, a.agree ? "agree" : "differ"));
  }
  return html + "</table></div>\n";
}

std::string page(const std::vector<VerifiedScene>& scenes) {
  std::vector<std::string> failures;
  std::size_t comparisons = 0;
  bool partial = false;
  for (const VerifiedScene& scene : scenes) {
    const std::vector<std::string> own = scene.failures();
    failures.insert(failures.end(), own.begin(), own.end());
    comparisons += scene.comparisons();
    partial = partial || scene.partial;
  }
  std::string html = fmt::format("<h1>Obscura {}: do the methods agree?</h1>\n", OBSCURA_VERSION);
  if (failures.empty()) {
    html += fmt::format("<p class=\"{}\">{} comparisons in {} scenes: {}.</p>\n", partial ? "differ" : "agree",
                        comparisons, scenes.size(), partial ? "stopped before the end" : "all agree");
  } else {
    html += fmt::format("<p class=\"differ\">{} of {} comparisons fail:</p>\n<ul>\n", failures.size(), comparisons);
    for (const std::string& sentence : failures) html += fmt::format("<li>{}</li>\n", html_escaped(sentence));
    html += "</ul>\n";
  }
  html +=
      "<p class=\"about\">Values stand with their standard errors. Two methods agree where their difference is within "
      "the limit times "
      "their joint error, after the photon map's estimated bias and the ordinates' estimated error are taken off. "
      "&ldquo;Would be "
      "seen&rdquo; is the difference that the comparison finds in 99.9 % of cases. Pictures: each method's radiance "
      "and its error, then "
      "differences in units of the joint error and in per cent; blue is less, red is more.</p>\n";
  for (const VerifiedScene& scene : scenes) {
    html += fmt::format("<h2>{}</h2>\n<p class=\"about\">{}</p>\n<ul class=\"what\">\n", html_escaped(scene.name),
                        html_escaped(scene.about));
    for (const VerifyMethod& m : scene.methods) {
      html += m.refusal.empty() ? fmt::format("<li>{}: {}; {:.1f} s</li>\n", m.name, html_escaped(m.what), m.seconds)
                                : fmt::format("<li>without {}: {}</li>\n", m.name, html_escaped(m.refusal));
    }
    html += "</ul>\n";
    for (std::size_t band = 0; band < scene.bands.size() && !scene.partial; ++band) {
      if (scene.bands.size() > 1) html += fmt::format("<h3>{}</h3>\n", html_escaped(scene.bands[band]));
      html += pictures_of(scene, band);
    }
    if (!scene.partial) html += table_of(scene);
  }
  return html_page("Obscura: verification", html);
}

}  // namespace

void write_verify_html(const std::filesystem::path& file, const std::vector<VerifiedScene>& scenes) {
  write_whole_stream(file, [&](std::ostream& stream) { stream << page(scenes); });
}

}  // namespace obscura
