#include "src/diagnose/signal.hpp"
#include <cmath>

namespace quern {
namespace {

BodyReading reading_of(Channel channel) {
  if (channel == Channel::force) return BodyReading::force;
  if (channel == Channel::displacement) return BodyReading::displacement;
  return channel < Channel::vx ? BodyReading::position : channel < Channel::wx ? BodyReading::velocity : BodyReading::spin;
}

}  // namespace

SignalReader::SignalReader(const RecordedRun& run, const InstrumentSettings& settings, double start) {
  for (const Series& series : run.series) {
    const Instrument instrument = settings.of(name_of(series.channel), quantity_of(series.channel));
    told_.push_back({series.t, ShownReading(reading_of(series.channel), axis_of(series.channel), instrument), 0});
    for (double& t : told_.back().times) t -= start + instrument.shift;
    values_.emplace_back(series.value.size(), std::nan(""));
  }
}

void SignalReader::begin(const BodyState& first) {
  for (std::size_t k = 0; k < told_.size(); ++k) {
    Told& one = told_[k];
    one.shown.begin(first, one.times.empty() ? first.time : one.times.front());
    for (; one.next < one.times.size() && one.times[one.next] <= first.time; ++one.next) values_[k][one.next] = one.shown.before(first, one.times[one.next]);
  }
}

bool SignalReader::see(const BodyState& before, const BodyState& now) {
  bool more = false;
  for (std::size_t k = 0; k < told_.size(); ++k) {
    Told& one = told_[k];
    const std::size_t from = one.next;
    while (one.next < one.times.size() && one.times[one.next] <= now.time) ++one.next;
    one.shown.read(before, now, {one.times.data() + from, one.next - from}, values_[k].data() + from);
    more |= one.next < one.times.size();
  }
  return more;
}

}  // namespace quern
