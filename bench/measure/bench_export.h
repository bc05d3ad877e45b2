// Writes results of `skywave bench` in the forms of other tools.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/names.h"
#include "bench/measure/bench_record.h"

namespace skywave {

enum class ExportFormat {
  kBmf,    // Bencher Metric Format: bencher.dev/docs/reference/bencher-metric-format
  kGoogle  // JSON of Google Benchmark's reporter, which its tools and many services read
};
template <>
inline constexpr auto kEnumNames<ExportFormat> = std::to_array<Named<ExportFormat>>(
    {{ExportFormat::kBmf, "bmf"}, {ExportFormat::kGoogle, "google"}});

// Bencher's measures: latency [ns] and throughput [operations/s] of each scene, an operation being
// a sample, with the ends of intervals of 95 %, and rays per second. A suite of several scenes adds
// itself, with geometric means over its scenes.
// Google's: one entry for each repetition and, if there are several, mean, median, standard
// deviation and coefficient of variation.
nlohmann::ordered_json Export(const BenchRecord& record, ExportFormat format);

}  // namespace skywave
