#include "nanoweft/record/table_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr const char* stretchMark = "# rows every ";
/// Bytes of a line that are looked at; no row of ours has more.
constexpr std::size_t longestLine = 1 << 16;
/// Bytes of a head that are looked at.
constexpr std::int64_t longestHead = 1 << 24;

/// Reads lines, of any length, in blocks.
class Lines {
 public:
  Lines(int descriptor, std::int64_t begin)
      : descriptor_(descriptor), end_(begin), offset_(begin) {}

  /// False at the end of the file.
  bool next() {
    begin_ = end_;
    text_.clear();
    whole_ = false;
    for (char c; get(c);) {
      ++end_;
      if (c == '\n') {
        whole_ = true;
        return true;
      }
      if (text_.size() < longestLine) text_ += c;
    }
    return end_ > begin_;
  }
  const std::string& text() const { return text_; }
  bool whole() const { return whole_; }  ///< ends with a newline
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }

 private:
  bool get(char& c) {
    if (at_ == filled_) {
      ssize_t got;
      do got = ::pread(descriptor_, block_.data(), block_.size(), offset_);
      while (got < 0 && errno == EINTR);
      if (got <= 0) return false;
      at_ = 0;
      filled_ = static_cast<std::size_t>(got);
      offset_ += got;
    }
    c = block_[at_++];
    return true;
  }

  int descriptor_;
  std::int64_t begin_ = 0, end_, offset_;
  std::vector<char> block_ = std::vector<char>(1 << 16);
  std::size_t at_ = 0, filled_ = 0;
  std::string text_;
  bool whole_ = false;
};

/// "100 steps from step 0, every 50 from step 200"; nothing when it is not that.
std::vector<TableStretch> parseStretches(const std::string& text) {
  std::vector<TableStretch> result;
  std::istringstream parts(text);
  std::string every, steps, from, step;
  TableStretch s{};
  parts >> s.interval >> steps >> from >> step >> s.begin;
  for (;;) {
    const bool rises = result.empty() || s.begin >= result.back().begin;
    if (!parts || s.interval < 1 || s.begin < 0 || !rises) return {};
    // Of two that begin at one step the later holds.
    if (!result.empty() && s.begin == result.back().begin) result.pop_back();
    result.push_back(s);
    char comma;
    if (!(parts >> comma)) return result;
    parts >> every >> s.interval >> from >> step >> s.begin;
  }
}

/// The step of a row of `columns` finite numbers; nothing when the line is none.
std::optional<std::int64_t> stepOf(const std::string& line, std::size_t columns) {
  const char* at = line.c_str();
  const char* const end = at + line.size();
  std::int64_t step = -1;
  for (std::size_t k = 0; k < columns; ++k) {
    const bool starts = (*at >= '0' && *at <= '9') || (k > 0 && *at == '-');
    if (!starts) return std::nullopt;
    char* stop;
    errno = 0;
    if (k == 0)
      step = std::strtoll(at, &stop, 10);
    else if (!std::isfinite(std::strtod(at, &stop)))
      return std::nullopt;
    if (k == 0 && errno != 0) return std::nullopt;
    const bool last = k + 1 == columns;
    if (last ? stop != end : *stop != ',') return std::nullopt;
    at = stop + 1;
  }
  return step;
}

std::string stepRange(const TableHead& head, std::int64_t first, std::int64_t end) {
  std::int64_t last = first;
  for (std::int64_t next; (next = head.nextRow(last)) < end;) last = next;
  return first == last ? format("the row of step %lld is missing", static_cast<long long>(first))
                       : format("the rows of steps %lld to %lld are missing",
                                static_cast<long long>(first), static_cast<long long>(last));
}

}  // namespace

std::string TableHead::text() const {
  std::string result = provenance ? provenance->tableHead() : "";
  for (const TableStretch& s : stretches)
    result += format("%s%lld%s from step %lld", &s == &stretches[0] ? stretchMark : ", every ",
                     static_cast<long long>(s.interval), &s == &stretches[0] ? " steps" : "",
                     static_cast<long long>(s.begin));
  return result + "\n" + columns + "\n";
}

std::int64_t TableHead::nextRow(std::int64_t step) const {
  for (std::size_t k = 0;; ++k) {
    const TableStretch& s = stretches[k];
    const std::int64_t next = (std::max(step, s.begin) / s.interval + 1) * s.interval;
    if (k + 1 == stretches.size() || next <= stretches[k + 1].begin) return next;
  }
}

TableHead readTableHead(int descriptor) {
  TableHead head;
  Lines lines(descriptor, 0);
  std::string origin;
  const std::string mark = stretchMark;
  while (lines.end() < longestHead && lines.next() && lines.whole()) {
    head.end = lines.end();
    ++head.lines;
    if (lines.text().starts_with(mark)) {
      head.stretches = parseStretches(lines.text().substr(mark.size()));
    } else if (lines.text().starts_with("#")) {
      origin += lines.text() + "\n";
    } else {
      head.columns = lines.text();
      break;
    }
  }
  std::istringstream text(origin);
  head.provenance = Provenance::fromTable(text);
  return head;
}

TableRows checkTableRows(int descriptor, const TableHead& head, std::int64_t restartStep,
                         bool ends) {
  const auto columns = static_cast<std::size_t>(std::ranges::count(head.columns, ',')) + 1;
  const std::int64_t first = head.stretches[0].begin;
  TableRows rows;
  rows.end = head.end;
  if (first > restartStep) return rows;  // the restart writes all rows again
  Lines lines(descriptor, head.end);
  std::int64_t wanted = first, previous = -1;
  bool later = false;  // beyond the restart's step: the restart writes these rows again
  for (long long number = head.lines + 1; lines.next(); ++number) {
    const auto step = lines.whole() ? stepOf(lines.text(), columns) : std::nullopt;
    auto fault = [&](const std::string& what) {
      rows.problem = format("line %lld: ", number) + what;
      return rows;
    };
    if (!step && (later || wanted > restartStep)) {
      later = true;
      continue;
    }
    if (!step)
      return fault(lines.whole() ? format("no row of %zu finite numbers", columns)
                                 : "the last line is torn");
    if (*step <= previous && *step <= restartStep)
      return fault(format("step %lld stands after step %lld", static_cast<long long>(*step),
                          static_cast<long long>(previous)));
    previous = std::max(previous, *step);
    if (*step > restartStep) {
      later = true;
      continue;
    }
    if (*step > wanted) return fault(stepRange(head, wanted, *step) + " before it");
    const bool closing = *step == restartStep && *step < wanted;
    if (*step < wanted && !closing)
      return fault(format("no row of step %lld belongs there", static_cast<long long>(*step)));
    if (closing && !ends) continue;
    rows.last = *step;
    rows.end = lines.end();
    wanted = head.nextRow(*step);
  }
  // A run that was killed early may have left a table without a row.
  if (wanted <= restartStep && !(rows.last < 0 && first == restartStep))
    rows.problem = stepRange(head, wanted, restartStep + 1) + " at its end";
  return rows;
}

}  // namespace nanoweft
