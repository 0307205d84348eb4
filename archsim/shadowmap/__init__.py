"""Shadow maps fitted to a view: standard, warped, partitioned, logarithmic; and how far they alias. [Lloyd07]
sec. 3
"""
