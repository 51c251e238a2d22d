"""The methods of each class of API 2, over the functions of API 1."""
