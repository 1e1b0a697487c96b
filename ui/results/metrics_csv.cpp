#include "ui/results/metrics_csv.h"

#include "datasets/tables/csv_reader.h"
#include "planner/measures/metric_table.h"

namespace retractor::ui {

namespace {

    std::string cell(const nlohmann::ordered_json& object, const char* key)
    {
        return object.is_object() && object.contains(key) && object[key].is_number() ? object[key].dump()
                                                                                     : std::string();
    }

} // namespace

std::string metrics_csv_header()
{
    std::string line = "approach,target,verdict";
    for (const planner::MetricField& metric : planner::metric_fields()) {
        line += std::string(",") + metric.key;
        if (metric.error != nullptr)
            line += std::string(",") + metric.key + "_error";
    }
    return line;
}

std::string metrics_csv_row(const nlohmann::ordered_json& approach)
{
    const auto text = [&](const char* key) { return datasets::csv_quoted(approach.value(key, std::string())); };
    std::string line = text("name") + "," + text("target") + ",";
    if (approach.contains("verdict"))
        line += datasets::csv_quoted(approach["verdict"].value("light", std::string()));
    const nlohmann::ordered_json bars
        = approach.contains("error_estimate") ? approach["error_estimate"] : nlohmann::ordered_json();
    for (const planner::MetricField& metric : planner::metric_fields()) {
        line += "," + cell(approach, metric.key);
        if (metric.error != nullptr)
            line += "," + cell(bars, metric.key);
    }
    return line;
}

std::string metrics_csv_empty_row(const std::string& approach)
{
    return metrics_csv_row(nlohmann::ordered_json { { "name", approach } });
}

} // namespace retractor::ui
