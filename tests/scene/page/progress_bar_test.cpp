#include "scene/page/progress_bar.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

using namespace obscura;

namespace {

struct Recorder {
  double now = 0;
  std::string text;
  ProgressBar::Clock clock() {
    return [this] { return now; };
  }
  ProgressBar::Write write() {
    return [this](std::string_view t) { text += t; };
  }
};

}  // namespace

TEST_CASE("the bar tells the time that is left", "[scene][progress]") {
  Recorder r;
  ProgressBar bar(true, r.clock(), r.write());
  bar.report("tracing", 0, 100);
  CHECK(r.text.find("0 %") != std::string::npos);
  r.now = 20;
  bar.report("tracing", 25, 100);  // 20 s for a quarter: 60 s for the rest
  CHECK(r.text.find("25 %, 1 min 0 s left") != std::string::npos);
  CHECK(r.text.find("[######..................]") != std::string::npos);
  CHECK(r.text.find('\n') == std::string::npos);
  bar.report("rendering", 0, 10);
  CHECK(r.text.find("tracing                  20 s") != std::string::npos);
  bar.finish();
  CHECK(std::count(r.text.begin(), r.text.end(), '\n') == 2);
}

TEST_CASE("a bar is redrawn at most ten times a second", "[scene][progress]") {
  Recorder r;
  ProgressBar bar(true, r.clock(), r.write());
  for (int i = 0; i < 10000; ++i) {
    r.now = i * 1e-4;
    bar.report("tracing", static_cast<std::uint64_t>(i), 10000);
  }
  CHECK(std::count(r.text.begin(), r.text.end(), '\r') <= 11);
  CHECK(std::count(r.text.begin(), r.text.end(), '\r') >= 9);
}

TEST_CASE("without a terminal there are whole lines, and few", "[scene][progress]") {
  Recorder r;
  {
    ProgressBar bar(false, r.clock(), r.write());
    for (int i = 0; i <= 250; ++i) {
      r.now = i * 0.1;
      bar.report("tracing", static_cast<std::uint64_t>(i), 250);
    }
    bar.report("developing", 1, 1);  // too short for a line
  }
  CHECK(r.text == "tracing: 40 %, 15 s left\ntracing: 80 %, 5.0 s left\ntracing: 25 s\n");
}

TEST_CASE("durations read as people say them", "[scene][progress]") {
  CHECK(duration_text(0.42) == "0.4 s");
  CHECK(duration_text(59.6) == "1 min 0 s");
  CHECK(duration_text(200) == "3 min 20 s");
  CHECK(duration_text(7500) == "2 h 5 min");
}
