"""Odd words for where a number, a name or a path belongs."""

TEXTS = (
    "", " ", "2", "2 mm", "-2 mm", "0 mm", "1e-12 m", "1e12 m", "1e400 m", "nan", "inf", "-inf mm", "2 kg", "2 mm mm",
    "2,5 mm", "2 mN", "5 mHz", "5 THz", "10 deg", "1e9 deg", "1 N", "1e9 N", "-1e9 N", "1e-30 N", "1 Pa", "1 TPa",
    "0:1:3", "1 mm:2 mm:1000000", "1:1:2", ":", "::", "first:last:count", "copper", "ecoflex-00-30", "µ", "²", "\x7f",
    "🦔", "../../etc/passwd", "/dev/zero", "/dev/null", "/", ".", "a" * 5000, "\n", "%s%n", "{}", "[]", "'", '"', "-",
    "--", "-1", "1e3", "0x10", "1_000", "True", "none",
)
