"""Which parameters each firmware has, one file per firmware and `common` for what all of them share."""
