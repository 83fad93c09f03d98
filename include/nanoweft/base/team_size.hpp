/// How many of its threads a rank lets work while other programs use the same cores.
///
/// A team waits for its slowest thread, so that one thread without a core holds all others up, and
/// a smaller team may be faster. Results do not depend on its size.
#pragma once

#include <cstddef>
#include <optional>

namespace nanoweft {

/// The cores of this process from now on.
class CoreWatch {
 public:
  CoreWatch();
  /// How many that this process may use have had nothing to do, or ran what others had put behind
  /// (nice). None where the system does not tell, or too little time has passed.
  std::optional<double> spare() const;
  /// How many this process has used.
  double used() const;

 private:
  double wall_, used_;           ///< seconds; of all cores that this process has used
  std::optional<double> spare_;  ///< seconds of all cores that nobody needed
};

/// Finds the size by trying: what one size costs beside the next smaller or larger one.
class TeamTrials {
 public:
  explicit TeamTrials(int most) : most_(most), size_(most) {}

  int most() const { return most_; }
  int size() const { return size_; }

  /// Has enough been measured of the present size? `cost`: time of a step; `delay`: share of
  /// that time for which a thread had work but no core; `seconds`: how long has been measured.
  bool enough(long steps, double cost, double delay, double seconds) const;
  /// Takes what has been measured and chooses the next size. `freeCores`: how many cores meanwhile
  /// did nothing, or ran niced programs; 1 where that is not known.
  void note(double cost, double delay, double seconds, double freeCores = 1.0);
  /// Begins with a smaller team where so many `cores` are too few for all threads.
  void begin(double cores);
  /// The same where `delay`, as above but of what came before the first step, says that threads
  /// share a core.
  void lookBack(double delay);

 private:
  static bool disturbed(double delay);
  /// Is this a trial, and so dear that nothing more need be measured?
  bool hopeless(double cost) const { return settled_ > 0 && cost > 2.0 * cost_; }

  int most_, size_;
  int settled_ = 0;                 ///< size before the trial; 0: there is none
  double cost_ = 0;                 ///< of that size
  bool smallerIsNoBetter_ = false;  ///< as the last trial of a smaller size found
  double held_ = 0, hold_ = shortestHold;

  static constexpr double shortestHold = 0.5, longestHold = 30;  ///< seconds between trials
};

/// The same for the teams of this process (onShares). Measures; keeps `most` threads where `fixed`
/// or where the system does not tell how long threads waited for a core. Only one at a time.
class TeamSize {
 public:
  /// `cores`: since the start of this process.
  TeamSize(int most, bool fixed, const CoreWatch& cores);
  ~TeamSize();
  TeamSize(const TeamSize&) = delete;
  TeamSize& operator=(const TeamSize&) = delete;

  /// To be called before the first step.
  void startSteps();
  /// To be called after each step, with the number of shares that the work is in. Returns whether
  /// the team waits for more of them.
  bool noteStep(std::size_t shares);
  /// Size of the teams, in the mean over the time of their work.
  double mean() const;

 private:
  void startWindow();
  /// Takes note of a step, and chooses the next size when enough is known.
  void measure();

  bool fixed_;
  TeamTrials trials_;
  long steps_ = 0;
  bool waits_ = false;  ///< for shares
  /// At the start of what is being measured.
  double begin_ = 0, delayed_ = 0;
  CoreWatch cores_;
  double threadSeconds_ = 0, seconds_ = 0;  ///< of all that has been measured
};

}  // namespace nanoweft
