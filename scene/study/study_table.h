// How a study's numbers read, shared by its tables, its page and its plots.
#pragma once

#include <string>

#include "scene/page/svg_plot.h"
#include "scene/study/study.h"

namespace obscura::detail {

/// "2.31 +- 0.12 %"; "< 0.08 %" where the error cannot be told from none.
std::string percent_text(const RootError& error);
/// Three digits: "0.0123 s", "4.56 s", "123 s".
std::string seconds_text(double seconds);
std::string memory_text(double bytes);
/// "10 %"
std::string target_text(double target);
/// Which reference, how good.
std::string reference_text(const Study& study);
/// Of the setting with the least measured error.
std::string not_reached_text(const Study& study);
/// --set options that make `obscura render` repeat a run; empty for ordinates.
std::string command_text(const Study& study, const StudyRun& run);

SvgPlot time_plot(const Study& study);
SvgPlot memory_plot(const Study& study);
/// Bias and noise of one method's ladder against time.
SvgPlot parts_plot(const Study& study, const MethodType* method);

}  // namespace obscura::detail
