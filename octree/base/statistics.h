// Means and their errors: running moments, means over batches, and a sum whose rounding error does
// not grow with the number of terms.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace obscura {

/// Count, mean and variance of a stream of numbers (Welford 1962; merging by Chan, Golub & LeVeque
/// 1979). Same numbers in the same order, merged in the same order, give the same bits.
class Moments {
 public:
  constexpr void add(double x) noexcept {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(count_);
    squares_ += delta * (x - mean_);
  }

  constexpr void merge(const Moments& other) noexcept {
    if (other.count_ == 0) return;
    if (count_ == 0) {
      *this = other;
      return;
    }
    const double n = static_cast<double>(count_);
    const double m = static_cast<double>(other.count_);
    const double delta = other.mean_ - mean_;
    count_ += other.count_;
    mean_ += delta * (m / (n + m));
    squares_ += other.squares_ + delta * delta * (n * m / (n + m));
  }

  constexpr std::uint64_t count() const noexcept { return count_; }
  /// 0 where nothing was added.
  constexpr double mean() const noexcept { return mean_; }
  /// Unbiased variance of one number; 0 for fewer than two numbers.
  constexpr double variance() const noexcept { return count_ < 2 ? 0.0 : squares_ / static_cast<double>(count_ - 1); }
  /// Of the mean. Infinite for fewer than two numbers: nothing is known of their scatter.
  double standard_error() const noexcept {
    if (count_ < 2) return std::numeric_limits<double>::infinity();
    return std::sqrt(variance() / static_cast<double>(count_));
  }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0;
  double squares_ = 0;  // sum of squared deviations from the mean
};

/// Mean over independent batches and its standard error, which has (batches - 1) degrees of
/// freedom: (mean - truth) / standard_error follows Student's t, not the normal law.
struct BatchMean {
  double mean = 0;
  double standard_error = std::numeric_limits<double>::infinity();
};

/// A number as a method has measured it.
struct Measured {
  double value = 0;
  double error = 0;                                          ///< standard error
  double freedom = std::numeric_limits<double>::infinity();  ///< degrees of freedom of the error
  double bias = 0;  ///< about one standard deviation of what is wrong and not random, >= 0
};

/// No batch: mean 0; fewer than two: infinite error.
BatchMean batch_mean(std::span<const double> batches) noexcept;

/// Probability that |t| of Student's law exceeds a value; infinite degrees of freedom: the normal law.
double student_tail(double t, double degrees_of_freedom);
/// The |t| that is exceeded with the given probability, 0 < probability < 1.
double student_limit(double probability, double degrees_of_freedom = std::numeric_limits<double>::infinity());

/// Sum in a fixed tree order: rounding error grows with log2 of the count (Higham 1993), and the
/// result depends on the order of the values only.
double pairwise_sum(std::span<const double> values) noexcept;

}  // namespace obscura
