# The README's two commands on Debian 12: the image is built by the first, a container runs the second.
#   docker build --tag diffsac . && docker run --rm diffsac
FROM debian:12
WORKDIR /diffsac
COPY . .
RUN scripts/reproduce.sh line
CMD ["scripts/test.sh"]
