#include "planner/measures/metric_table.h"

#include "planner/measures/metrics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <set>
#include <string>

namespace retractor::planner {
namespace metric_table_test {

    TEST(MetricTable, EveryRowIsANumberOfItsOwnInTheDocument)
    {
        FieldMetrics field;
        double value = 0.25;
        for (const MetricField& metric : metric_fields())
            field.*metric.member = value += 1.0;
        const auto document = metrics_document({ field }).at("approaches").at(0);
        std::set<std::string> keys;
        std::set<double> values;
        for (const MetricField& metric : metric_fields()) {
            EXPECT_TRUE(keys.insert(metric.key).second) << metric.key << " comes twice";
            EXPECT_EQ(document.at(metric.key).get<double>(), metric.of(field)) << metric.key;
            EXPECT_TRUE(values.insert(metric.of(field)).second) << metric.key << " is another row's member";
            EXPECT_EQ(&metric_field(metric.key), &metric);
            EXPECT_STRNE(metric.caption, "") << metric.key;
            EXPECT_EQ(metric.error != nullptr, metric.bar == MetricBar::estimated) << metric.key;
        }
    }

    TEST(MetricTable, NumbersAreReadInTheirUnits)
    {
        EXPECT_EQ(metric_text(metric_field("seen_best_eye"), 0.6234), "62.3 %");
        EXPECT_EQ(metric_text(metric_field("opening_area_mm2"), 4210.0), "42.1 cm²");
        EXPECT_EQ(metric_text(metric_field("working_distance_mm"), 80.6, 0), "81 mm");
        EXPECT_EQ(metric_text(metric_field("access_vertical_deg"), -12.4, 0), "-12°");
        EXPECT_EQ(metric_text(metric_field("hook_force_N"), 41.26), "41.3 N");
        EXPECT_EQ(metric_text(metric_field("max_volume_ratio"), 1.256, 2), "1.26");
        EXPECT_EQ(metric_number(metric_field("opening_area_mm2"), 4210.0), "42.1");
    }

    TEST(MetricTable, ANumberHasABarWhereErrorsWereEstimated)
    {
        FieldMetrics field;
        EXPECT_FALSE(metric_error(metric_field("opening_width_mm"), field));
        ErrorBars& bars = field.error.emplace();
        bars.opening_width_mm = 1.25;
        EXPECT_EQ(metric_error(metric_field("opening_width_mm"), field), 1.25);
        bars.seen_best_eye = 0.03;
        EXPECT_EQ(metric_error(metric_field("seen_best_eye"), field), 0.03);
        EXPECT_FALSE(metric_error(metric_field("strain_p99"), field)) << "it has no bar";
        bars.message = "the wall was not solved";
        EXPECT_FALSE(metric_error(metric_field("opening_width_mm"), field));
    }

} // namespace metric_table_test
} // namespace retractor::planner
