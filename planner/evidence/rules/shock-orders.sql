-- Shock after intravenous contrast medium at CT, found in accounting data and the order entry of inpatients [Shinohara et
-- al., method of identifying medical complications from hospital information system data, figure 2].
-- As in accounting data alone, but a drug that was ordered was no emergency. Order entry exists for inpatients only:
-- where nothing is known of an order, the drug counts.
SELECT e.examination
FROM examination AS e
WHERE e.contrast = 1
  AND EXISTS (SELECT 1 FROM administration AS a
              WHERE a.patient = e.patient AND a.day = e.day
                AND a.drug IN ('antihistamine', 'steroid')
                AND (a.route = 'iv' OR a.examination = e.examination)
                AND coalesce(a.ordered, 'no') <> 'yes')
  AND EXISTS (SELECT 1 FROM oxygen AS o WHERE o.patient = e.patient AND o.day = e.day)
  AND NOT EXISTS (SELECT 1 FROM surgery AS s WHERE s.patient = e.patient AND s.day = e.day)
  AND NOT EXISTS (SELECT 1 FROM administration AS b
                  WHERE b.patient = e.patient AND b.day BETWEEN e.day - 3 AND e.day + 3 AND b.day <> e.day
                    AND b.drug IN ('antihistamine', 'steroid'))
ORDER BY e.day, e.examination
